use slipstream_diagnose::*;
use slipstream_recording::{Map, Pieces, read, Recording};
use std::time::Instant;
fn load(p: &str) -> Recording { slipstream_recording::read(std::path::Path::new(p)).unwrap().recording }
fn main() {
    let a: Vec<String> = std::env::args().skip(1).collect();
    let base = load(&a[0]);
    let src = load(&a[1]);
    let only: Option<&String> = a.get(2);
    let keep = |mut r: Recording| { if let Some(n) = only { r.robots.retain(|x| n.split(',').any(|m| m == x.name)); } r };
    let base = keep(base); let src = if a.get(3).is_some() { src } else { keep(src) };
    let t = Instant::now();
    let bs = vec![base];
    let model = |_: &str| None;
    let mut w = match Watch::new(&Request { recordings: &bs, against: &[], model_of: &model, excluded: &[], excluded_s: &[], progress: &|_| () }) { Ok(w) => w, Err(e) => { println!("{e}"); return; } };
    println!("learnt in {:.1?}", t.elapsed());
    let t = Instant::now();
    let mut asked = std::time::Duration::ZERO;
    let mut last = 0.0;
    for (t_s, piece) in Pieces::new(src, 0.5) {
        last = t_s;
        show(w.hear(&piece));
        while let Some(q) = w.question() {
            let t = Instant::now();
            let ans = q.diagnose();
            asked += t.elapsed();
            if let Err(e) = &ans { println!("   diagnosis: {e}"); }
            let ev = w.answered(&q, &ans);
            if ev.is_empty() { println!("   diagnosis says nothing"); }
            show(ev);
        }
    }
    println!("heard {last:.0} s in {:.2?} + {:.1?} of diagnoses", t.elapsed() - asked, asked);
}
fn show(ev: Vec<Event>) {
    for e in ev {
        match e {
            Event::Change(c) => {
                let p: Vec<String> = c.finding.parameters.iter().map(|p| format!("{} {:?}->{:?} {:?}", p.name, p.nominal, p.estimate.map(|x| (x*1e4).round()/1e4), p.ci95)).collect();
                println!("{:8.1} since {:8.1} {} {} {} | {} | confused {:?} gain {:.1}", c.t_s, c.onset_s, c.robot, c.state.name(), c.finding.effect, p.join("; "), c.finding.confused_with, c.finding.evidence.log_likelihood_gain);
            }
            Event::Fault(t, w) => println!("{t:8.1} fault {}: {}", w.id, w.statement),
        }
    }
}
