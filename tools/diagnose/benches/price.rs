//! What a diagnosis costs: predictions over 5 s, the filter with its noise sizes, the whole.
//!
//! 60 s of one robot with torque commands, encoders and a camera. The limit beside is the plant
//! alone, once over the same commands at the steps of the fit, with nothing compared. What takes
//! seconds runs once or twice and comes in tables at the end. `cargo bench -p slipstream-diagnose`.

#![expect(
    clippy::unwrap_used,
    reason = "a benchmark may stop at the first surprise"
)]

use std::hint::black_box;
use std::sync::LazyLock;
use std::time::Instant;

use divan::Bencher;
use nix::sys::resource::{UsageWho, getrusage};
use rayon::{ThreadPool, ThreadPoolBuilder};
use slipstream_answer::Answer;
use slipstream_bus::RobotModel;
use slipstream_diagnose::{Request, diagnose, predict};
use slipstream_recording::Recording;
use slipstream_sim::effects::CATALOGUE;
use slipstream_sim::{Command, Robot};

const LENGTH_S: f64 = 60.0;
/// How long a command holds (s), and the steps of the fit in it.
const HOLD_S: f64 = 0.02;
const STEPS: u32 = 10;
/// What a whole diagnosis is to take at most (s), and on how many cores.
const AIM_S: f64 = 10.0;
const CORES: usize = 2;
/// How often a price is taken; the least counts.
const TIMES: u32 = 2;

/// What the robots of the hypotheses have and their models lack.
const LEFT_OUT: &str = "rolling_resistance";

static MATCHING: LazyLock<Case> = LazyLock::new(|| {
    let model = RobotModel::default();
    Case::new(model.clone(), &model, slipstream_testkit::gentle)
});

static ROLLING: LazyLock<Case> = LazyLock::new(|| {
    let model = RobotModel::default();
    let truth = resisted(&model);
    Case::new(model, &truth, slipstream_testkit::gentle)
});

static SLIPPING: LazyLock<Case> = LazyLock::new(|| {
    let model = RobotModel::paper_with_slip();
    let truth = resisted(&model);
    Case::new(model, &truth, hard)
});

static SLIP_LEFT_OUT: LazyLock<Case> = LazyLock::new(|| {
    let truth = RobotModel::paper_with_slip();
    Case::new(RobotModel::default(), &truth, hard)
});

fn main() {
    divan::main();
    // a filter, a list or a test asks for less
    if std::env::args().skip(1).eq(["--bench".to_owned()]) {
        prices();
        wholes();
    }
}

/// A robot's nominal model, how it is driven, and what was recorded of it.
struct Case {
    nominal: RobotModel,
    torque: fn(f64) -> [f64; 2],
    recording: Recording,
}

impl Case {
    fn new(nominal: RobotModel, truth: &RobotModel, torque: fn(f64) -> [f64; 2]) -> Self {
        let recording = slipstream_testkit::record(truth, torque, LENGTH_S, 7);
        Self {
            nominal,
            torque,
            recording,
        }
    }

    /// Hands `ask` the request that tries no effect of `excluded`.
    fn asked<T>(&self, excluded: &[String], ask: impl FnOnce(&Request<'_>) -> T) -> T {
        ask(&Request {
            recordings: std::slice::from_ref(&self.recording),
            against: &[],
            model_of: &|_| Some(self.nominal.clone()),
            excluded,
            excluded_s: &[],
            progress: &|_| (),
        })
    }

    fn diagnosed(&self) -> Answer {
        self.asked(&[], |request| diagnose(request).unwrap().0)
    }

    fn predicted(&self) {
        let predictions = self.asked(&[], |request| predict(request).unwrap());
        black_box(predictions);
    }

    /// The nominal model under the filter, with no effect to try.
    fn filtered(&self) {
        let all: Vec<String> = CATALOGUE.iter().map(|info| info.id.to_owned()).collect();
        black_box(self.asked(&all, |request| diagnose(request).unwrap()));
    }
}

fn assert_found(answer: &Answer, effects: &[&str]) {
    let found: Vec<&str> = answer.findings.iter().map(|f| f.effect.as_str()).collect();
    assert_eq!(found, effects, "the prices are of another answer");
}

fn resisted(model: &RobotModel) -> RobotModel {
    model.clone().with(LEFT_OUT, &[("coefficient", 0.008)])
}

/// As gentle, with a jerk to and fro every two seconds under which both wheels slip.
fn hard(t_s: f64) -> [f64; 2] {
    let jerk_nm = match t_s % 2.0 {
        at_s if at_s < 0.24 => 0.1,
        at_s if at_s < 0.48 => -0.1,
        _ => 0.0,
    };
    slipstream_testkit::gentle(t_s).map(|torque_nm| torque_nm + jerk_nm)
}

/// The plant over the commands of a case.
fn drive(robot: &Robot, case: &Case) -> [f64; 3] {
    let mut state = robot.start([0.0; 3]);
    let step_s = HOLD_S / f64::from(STEPS);
    for hold in 0..(LENGTH_S / HOLD_S).round() as u32 {
        let from_s = f64::from(hold) * HOLD_S;
        let [right_nm, left_nm] = (case.torque)(from_s + 1e-6);
        let command = Command::Torque { right_nm, left_nm };
        for k in 0..STEPS {
            let t_s = from_s + f64::from(k) * step_s;
            robot.step(&mut state, t_s, step_s, &command);
        }
    }
    state.pose()
}

fn alone(bencher: Bencher<'_, '_>, case: &Case) {
    let robot = Robot::new(&case.nominal).unwrap().draft();
    bencher.bench_local(|| drive(black_box(&robot), case));
}

#[divan::bench(name = "the plant alone, rolling")]
fn plant_rolling(bencher: Bencher<'_, '_>) {
    alone(bencher, &ROLLING);
}

#[divan::bench(name = "the plant alone, slipping")]
fn plant_slipping(bencher: Bencher<'_, '_>) {
    alone(bencher, &SLIPPING);
}

fn predicted(bencher: Bencher<'_, '_>, case: &Case) {
    let pool = cores(1);
    bencher.bench_local(|| pool.install(|| case.predicted()));
}

#[divan::bench(name = "predict, rolling, one core", sample_size = 1)]
fn predict_rolling(bencher: Bencher<'_, '_>) {
    predicted(bencher, &ROLLING);
}

#[divan::bench(name = "predict, slipping, one core", sample_size = 1)]
fn predict_slipping(bencher: Bencher<'_, '_>) {
    predicted(bencher, &SLIPPING);
}

fn cores(count: usize) -> ThreadPool {
    let pool = ThreadPoolBuilder::new().num_threads(count);
    pool.build().unwrap()
}

/// CPU time of this process so far (s): unlike the clock on the wall, it leaves out what else runs.
fn cpu_s() -> f64 {
    let usage = getrusage(UsageWho::RUSAGE_SELF).unwrap();
    [usage.user_time(), usage.system_time()]
        .map(|time| time.tv_sec() as f64 + time.tv_usec() as f64 * 1e-6)
        .iter()
        .sum()
}

/// The least CPU time of some times of `work`, each `rounds` times over (s a round).
fn least_cpu_s(rounds: u32, work: impl Fn()) -> f64 {
    let once = || {
        let begin_s = cpu_s();
        (0..rounds).for_each(|_| work());
        (cpu_s() - begin_s) / f64::from(rounds)
    };
    (0..TIMES).map(|_| once()).fold(f64::INFINITY, f64::min)
}

/// Prints prices on one core, beside one simulation by the plant.
fn prices() {
    println!("\nCPU time on one core, and as a multiple of the plant alone");
    for (name, case) in [("rolling", &ROLLING), ("slipping", &SLIPPING)] {
        let robot = Robot::new(&case.nominal).unwrap().draft();
        let plant_s = least_cpu_s(20, || {
            black_box(drive(&robot, case));
        });
        let [predict_s, filter_s] = cores(1).install(|| {
            let predict_s = least_cpu_s(5, || case.predicted());
            [predict_s, least_cpu_s(1, || case.filtered())]
        });
        let row = |what: &str, s: f64| {
            let (ms, times) = (s * 1e3, s / plant_s);
            println!("  {name:<9} {what:<42} {ms:>9.1} ms {times:>7.1}");
        };
        row("the plant alone", plant_s);
        row("predict: starts fitted, all compared once", predict_s);
        row("diagnose without effects: noise sizes alone", filter_s);
    }
}

/// Prints what whole diagnoses take, with the whole catalogue to try.
fn wholes() {
    println!("\nwhole diagnosis on {CORES} cores, to take at most {AIM_S} s");
    let cases: [(&str, &Case, &[&str]); 3] = [
        ("match", &MATCHING, &[]),
        ("rolling resistance", &ROLLING, &[LEFT_OUT]),
        ("wheel slip", &SLIP_LEFT_OUT, &["wheel_slip"]),
    ];
    for (name, case, effects) in cases {
        let (begin, begin_s) = (Instant::now(), cpu_s());
        let answer = cores(CORES).install(|| case.diagnosed());
        let wall_s = begin.elapsed().as_secs_f64();
        let cpu_s = cpu_s() - begin_s;
        assert_found(&answer, effects);
        println!("  {name:<20} {wall_s:>7.2} s, {cpu_s:>7.2} s of CPU time");
    }
}
