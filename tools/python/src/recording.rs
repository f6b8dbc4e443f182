//! Recordings: read from files, made of columns, written, taken apart.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use slipstream_bus::{Encoder, InputError};
use slipstream_recording::recording::{PosePoint, Recording as Inner, Robot, is_robot_name};
use slipstream_recording::{Import, Map, describe_robot, read_spooled, robot_file, robot_toml};

use crate::columns::{self, Columns};
use crate::errors::{input, of_recording};

/// A column as it arrives: its name and the bytes of its numbers (f64, little endian).
type Bytes = (String, Vec<u8>);
/// A robot as it arrives: its name, its streams, and numbers that describe its sensors.
type Arriving = (String, Vec<(String, Vec<Bytes>)>, Vec<(String, f64)>);

/// A recording in memory.
#[pyclass(module = "slipstream._slipstream", frozen)]
pub(crate) struct Recording {
    pub(crate) inner: Arc<Inner>,
    /// What reading it warned of.
    #[pyo3(get)]
    warnings: Vec<String>,
}

#[pymethods]
impl Recording {
    /// Reads a folder of CSV files or a bag; with the path of a map of topics or columns, where one is needed. `robots` are the
    /// files of robots, whose wheel joints help the guess of a bag's topics.
    #[staticmethod]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        topics: Option<PathBuf>,
        columns: Option<PathBuf>,
        robots: Vec<Vec<PathBuf>>,
    ) -> PyResult<Self> {
        let read = || -> slipstream_recording::Result<Import> {
            let map = Map::read(topics.as_deref(), columns.as_deref())?;
            let mut wheels = Vec::new();
            for files in &robots {
                let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
                wheels.push(describe_robot(&files)?.wheel_joints);
            }
            read_spooled(&path, &map, &wheels)?.load()
        };
        let read = py.detach(read);
        let import = read.map_err(|error| of_recording(py, error))?;
        Ok(Self {
            inner: Arc::new(import.recording),
            warnings: [import.guesses, import.warnings, import.on_model].concat(),
        })
    }

    /// Makes a recording of columns. `model` is the text of a robot.toml.
    #[staticmethod]
    fn from_columns(
        py: Python<'_>,
        name: String,
        robots: Vec<Arriving>,
        axle: bool,
        same_robot: bool,
        model: Option<String>,
    ) -> PyResult<Self> {
        let made = made(name, robots, axle, same_robot, model.as_deref());
        let inner = made.map_err(|error| input(py, &error))?;
        Ok(Self {
            inner: Arc::new(inner),
            warnings: Vec::new(),
        })
    }

    /// Writes it as a folder of CSV files.
    fn write(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        let written = py.detach(|| slipstream_recording::write_folder(&self.inner, &folder));
        written.map_err(|error| of_recording(py, error))
    }

    /// Its name.
    #[getter]
    fn name(&self) -> String {
        self.inner.name.clone()
    }

    /// Its model as the text of a robot.toml.
    #[getter]
    fn model(&self) -> Option<String> {
        self.inner.model.as_ref().map(robot_toml::to_text)
    }

    /// Every robot with its streams: names and bytes of columns.
    fn columns<'py>(&self, py: Python<'py>) -> Vec<Leaving<'py>> {
        let bytes = |values: &[f64]| {
            let all: Vec<u8> = values
                .iter()
                .flat_map(|value| value.to_le_bytes())
                .collect();
            PyBytes::new(py, &all)
        };
        let robots = self.inner.robots.iter();
        robots
            .map(|robot| {
                let streams = columns::of(robot).into_iter().map(|(stream, own)| {
                    let own = own.into_iter().map(|(name, values)| (name, bytes(&values)));
                    (stream, own.collect())
                });
                (robot.name.clone(), streams.collect())
            })
            .collect()
    }
}

/// The model that files describe together, as the text of a robot.toml. A file is a robot.toml, a URDF or the YAML of a
/// controller.
#[pyfunction]
pub(crate) fn model_text(py: Python<'_>, paths: Vec<PathBuf>) -> PyResult<String> {
    let paths: Vec<&Path> = paths.iter().map(PathBuf::as_path).collect();
    let model = py.detach(|| Ok(describe_robot(&paths)?.model()?));
    let model = model.map_err(|error| of_recording(py, error))?;
    Ok(robot_toml::to_text(&model))
}

/// A robot as it leaves.
type Leaving<'py> = (String, Vec<(String, Vec<(String, Bound<'py, PyBytes>)>)>);

fn made(
    name: String,
    robots: Vec<Arriving>,
    axle: bool,
    same_robot: bool,
    model: Option<&str>,
) -> Result<Inner, InputError> {
    let mut recording = Inner {
        name,
        origin: "arrays in memory".to_owned(),
        same_robot,
        ..Inner::default()
    };
    if let Some(text) = model {
        recording.model = Some(robot_file::parse(text, Path::new("robot"))?.model()?);
    }
    for (name, streams, numbers) in robots {
        if !is_robot_name(&name) {
            let remedy = "use letters, digits, - and _";
            return Err(InputError::new(&name, "is not a name of a robot", remedy));
        }
        let mut robot = Robot::named(name);
        robot.pose_point = axle.then_some(PosePoint::Axle);
        for (stream, own) in streams {
            let own = own
                .into_iter()
                .map(|(column, bytes)| (column, numbers_of(&bytes)));
            let own: Columns = (stream, own.collect());
            columns::add(&mut robot, &own)?;
        }
        for (key, value) in numbers {
            describe(&mut robot, &key, value)?;
        }
        recording.robots.push(robot);
    }
    Ok(recording)
}

fn numbers_of(bytes: &[u8]) -> Vec<f64> {
    let chunks = bytes.as_chunks::<8>().0.iter();
    chunks.map(|chunk| f64::from_le_bytes(*chunk)).collect()
}

/// A number that describes a sensor: counts per turn, or a standard deviation of its noise.
fn describe(robot: &mut Robot, key: &str, value: f64) -> Result<(), InputError> {
    let noise = &mut robot.noise;
    let field = match key {
        "encoder_counts_per_rev" => {
            if !Encoder::COUNTS.contains(&value) {
                let place = format!("{}: {key}", robot.name);
                let remedy = "give counts per turn of the wheel";
                return Err(InputError::new(place, format!("is {value}"), remedy));
            }
            robot.encoder_counts_per_rev = Some(value);
            return Ok(());
        }
        "pose_m" => &mut noise.pose_m,
        "pose_rad" => &mut noise.pose_rad,
        "imu_m_s2" => &mut noise.imu_m_s2,
        "imu_rad_s" => &mut noise.imu_rad_s,
        "wheel_rad" => &mut noise.wheel_rad,
        "odometry_m_s" => &mut noise.odometry_m_s,
        "odometry_rad_s" => &mut noise.odometry_rad_s,
        _ => {
            let place = format!("{}: {key}", robot.name);
            let remedy = "known are encoder_counts_per_rev and the keys of [robots.ROBOT.noise]";
            return Err(InputError::new(place, "is not known", remedy));
        }
    };
    *field = Some(value);
    Ok(())
}
