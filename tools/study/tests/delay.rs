//! A study of communication delay: independent of the number of threads and shards, and each point
//! equal to its single runs.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::sync::atomic::AtomicBool;

use slipstream_bus::Shard;
use slipstream_launch::in_process;
use slipstream_study::delay::{Form, Grid, Point, Study, merge, study};

/// Never set: the study is not interrupted.
static NEVER: AtomicBool = AtomicBool::new(false);

fn grid() -> Grid {
    Grid {
        runs: 2,
        delay_s: vec![0.0, 0.2],
        jitter_s: vec![0.0, 0.05],
        loss: vec![0.1],
        k_x: vec![1.0],
        torque_limit: vec!["none".to_owned(), "outer".to_owned()],
        protocol: vec!["ring".to_owned()],
        ..Grid::default()
    }
}

#[test]
fn threads_and_shards_do_not_change_the_study() {
    let whole = study(&grid(), Shard::WHOLE, 1, &NEVER).unwrap();
    assert_eq!(whole.points.len(), 8);
    assert_eq!(study(&grid(), Shard::WHOLE, 3, &NEVER).unwrap(), whole);
    let shards: Vec<(String, Study)> = (1..=3)
        .map(|index| {
            let shard = study(&grid(), Shard { index, of: 3 }, 2, &NEVER).unwrap();
            // As through a file.
            let text = serde_json::to_string(&shard).unwrap();
            (index.to_string(), serde_json::from_str(&text).unwrap())
        })
        .rev()
        .collect();
    assert_eq!(merge(&shards, 1).unwrap(), whole);
    let missing = merge(&shards[..2], 1).unwrap_err().to_string();
    assert!(missing.contains("shard 1/3 is missing"), "{missing}");
    let doubled = [shards[0].clone(), shards[0].clone()];
    let doubled = merge(&doubled, 1).unwrap_err().to_string();
    assert!(doubled.contains("a second time"), "{doubled}");
    let mut other = shards.clone();
    other[1].1.grid.runs = 3;
    let other = merge(&other, 1).unwrap_err().to_string();
    assert!(other.contains("of another study"), "{other}");
}

/// The numbers of a point equal those of `slipstream run`.
#[test]
fn a_point_combines_its_single_runs() {
    let grid = grid();
    let points: Vec<Point> = study(&grid, Shard { index: 1, of: 8 }, 1, &NEVER)
        .unwrap()
        .points;
    let point = &points[0];
    let mut experiment = point.cell.experiment().unwrap();
    let (mut slip_s, mut error_m, mut speed_m_s) = (0.0, 0.0f64, 0.0f64);
    for seed in 1..=grid.runs {
        experiment.settings.seed = seed.into();
        let reports = in_process::run(&experiment, true).unwrap();
        let robots = || reports.plant.robots.iter().skip(1);
        slip_s += robots().flat_map(|robot| robot.slip_time_s).sum::<f64>();
        error_m = robots()
            .filter_map(|robot| robot.max_spacing_error_m)
            .fold(error_m, f64::max);
        let agents = reports.agents.iter().skip(1);
        speed_m_s = agents
            .map(|agent| agent.max_desired_speed_m_s)
            .fold(speed_m_s, f64::max);
    }
    assert_eq!(point.slip_time_s, slip_s / f64::from(grid.runs));
    assert_eq!(point.max_spacing_error_m, error_m);
    assert_eq!(point.max_desired_speed_m_s, speed_m_s);
}

/// With a position at every tick and a delay of a whole number of ticks, the age is constant and the
/// transport delay gives exactly the measured speed; the literal form does not.
#[test]
fn constant_delay_is_a_transport_delay() {
    let grid = Grid {
        runs: 1,
        delay_s: vec![0.2],
        jitter_s: vec![0.0],
        loss: vec![0.0],
        protocol: vec!["periodic".to_owned()],
        ..grid()
    };
    let study = study(&grid, Shard { index: 1, of: 2 }, 1, &NEVER).unwrap();
    let point = &study.points[0];
    assert!((point.age_s - 0.2).abs() < 1e-9, "{}", point.age_s);
    // The difference is the rounding of the encoders.
    assert!(point.rms_m_s(Form::Transport) < 1e-3, "{point:?}");
    assert!(point.rms_m_s(Form::Undelayed) > 0.05, "{point:?}");
    assert!(point.rms_m_s(Form::LiteralSign) > 0.1, "{point:?}");
    assert!(point.rms_m_s(Form::Literal) > 0.1, "{point:?}");
}

#[test]
fn an_invalid_grid_is_refused_with_a_remedy() {
    let refused = |change: &dyn Fn(&mut Grid)| {
        let mut grid = grid();
        change(&mut grid);
        study(&grid, Shard::WHOLE, 1, &NEVER)
            .unwrap_err()
            .to_string()
    };
    assert!(refused(&|grid| grid.robots = 1).contains("at least 2"));
    assert!(refused(&|grid| grid.runs = 0).contains("at least 1"));
    assert!(refused(&|grid| grid.loss = vec![1.5]).contains("links.loss"));
    assert!(refused(&|grid| grid.delay_s = vec![f64::NAN]).contains("links.delay_s"));
    assert!(refused(&|grid| grid.protocol = vec!["pigeon".to_owned()]).contains("protocol"));
    assert!(refused(&|grid| grid.k_x.clear()).contains("--shard 1/1"));
}
