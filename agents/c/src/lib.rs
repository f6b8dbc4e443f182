//! Agents in C: the functions of `slipstream.h`.
//!
//! The layouts here are those of the header; `tools/cli/tests/agents.rs` runs a controller in C and compares states.
#![allow(
    unsafe_code,
    reason = "a C interface: each use says what the caller has to keep to"
)]

mod layout;

use std::ffi::{CStr, OsString, c_char, c_int, c_void};
use std::os::unix::ffi::OsStringExt;

use slipstream_agents::process::run_agent_with;
use slipstream_agents::{
    AgentContext, Controller, ControllerError, DesiredTwist, InnerInput, OuterInput, WheelTorques,
};
use slipstream_bus::message::{Extra, MAX_EXTRA};

use self::layout::{CHeard, CInnerInput, COuterInput};

/// `slipstream_context`: what is known when a controller is made.
pub struct CContext<'a> {
    context: &'a AgentContext<'a>,
    /// The first parameter that cannot be used.
    problem: std::cell::RefCell<Option<ControllerError>>,
}

/// `slipstream_controller`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CController {
    state: *mut c_void,
    outer: Option<unsafe extern "C" fn(*mut c_void, *const COuterInput, *mut f64) -> c_int>,
    inner: Option<unsafe extern "C" fn(*mut c_void, *const CInnerInput, *mut f64) -> c_int>,
    message: Option<unsafe extern "C" fn(*mut c_void, *mut f64) -> u32>,
}

/// The argument of `slipstream_run_agent` that makes a controller.
type Make = unsafe extern "C" fn(*const CContext<'_>, *mut CController) -> c_int;

/// A controller in C.
struct Own {
    c: CController,
    heard: Vec<CHeard>,
    extra: Extra,
}

// SAFETY: `run_agent_with` makes the controller and calls it on the thread that called `slipstream_run_agent`, so `state` never
// leaves that thread.
unsafe impl Send for Own {}

impl Controller for Own {
    fn outer(&mut self, now: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError> {
        self.heard.clear();
        self.heard.extend(now.heard.iter().map(CHeard::new));
        let input = COuterInput::new(now, &self.heard);
        let mut desired = [0.0; 2];
        let outer = self.c.outer.ok_or("its controller has no function outer")?;
        // SAFETY: the header gives this signature; input and output live until the call returns.
        let code = unsafe { outer(self.c.state, &raw const input, desired.as_mut_ptr()) };
        checked("outer", code)?;
        if let Some(message) = self.c.message {
            let mut extra = [0.0; MAX_EXTRA];
            // SAFETY: as above; the header says that there are MAX_EXTRA places.
            let count = unsafe { message(self.c.state, extra.as_mut_ptr()) };
            let numbers = extra.get(..count as usize).and_then(Extra::new);
            self.extra = numbers
                .ok_or_else(|| format!("message gave {count} numbers: give at most {MAX_EXTRA}"))?;
        }
        let [v, w] = desired;
        Ok(DesiredTwist { v, w })
    }

    fn inner(&mut self, now: &InnerInput<'_>) -> Result<WheelTorques, ControllerError> {
        let paper = now.paper();
        let Some(inner) = self.c.inner else {
            return Ok(paper);
        };
        let input = CInnerInput::new(now);
        let mut torque_nm = paper.torque_nm;
        // SAFETY: the header gives this signature; input and output live until the call returns.
        let code = unsafe { inner(self.c.state, &raw const input, torque_nm.as_mut_ptr()) };
        checked("inner", code)?;
        Ok(now.limited(torque_nm))
    }

    fn message(&self) -> Extra {
        self.extra
    }
}

fn checked(name: &str, code: c_int) -> Result<(), ControllerError> {
    match code {
        0 => Ok(()),
        code => Err(format!("{name} returned {code}").into()),
    }
}

/// The robot.
///
/// # Safety
/// `context` is the argument of the function that makes a controller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slipstream_robot(context: *const CContext<'_>) -> u32 {
    // SAFETY: by the condition above it points to a living context.
    unsafe { &*context }.context.robot()
}

/// A parameter of the controller.
///
/// # Safety
/// `context` is the argument of the function that makes a controller; `name` is a text that ends with 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slipstream_number(
    context: *const CContext<'_>,
    name: *const c_char,
    otherwise: f64,
) -> f64 {
    // SAFETY: by the condition above it points to a living context.
    let own = unsafe { &*context };
    // SAFETY: by the condition above it is a text that ends with 0.
    let name = unsafe { CStr::from_ptr(name) }.to_string_lossy();
    match own.context.number(&name, otherwise) {
        Ok(value) => value,
        Err(error) => {
            own.problem.borrow_mut().get_or_insert(error.into());
            otherwise
        }
    }
}

/// Runs the agent that the arguments of `main` name; returns the exit code of `main`.
///
/// # Safety
/// `argv` has `argc` texts that end with 0, as `main` gets them; `make` has the signature of the header and fills in functions with the
/// signatures of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slipstream_run_agent(
    argc: c_int,
    argv: *const *const c_char,
    make: Option<Make>,
) -> c_int {
    let count = usize::try_from(argc).unwrap_or(0);
    let argument = |place| {
        // SAFETY: by the condition above there are `argc` texts that end with 0.
        let text = unsafe { CStr::from_ptr(*argv.add(place)) };
        OsString::from_vec(text.to_bytes().to_vec())
    };
    let arguments: Vec<OsString> = (0..count).map(argument).collect();
    let code = run_agent_with(&arguments, |context| {
        let make = make.ok_or("slipstream_run_agent got no function that makes a controller")?;
        let own = CContext {
            context,
            problem: std::cell::RefCell::default(),
        };
        let mut c = CController {
            state: std::ptr::null_mut(),
            outer: None,
            inner: None,
            message: None,
        };
        // SAFETY: the header gives this signature; context and controller live until the call returns.
        let code = unsafe { make(&raw const own, &raw mut c) };
        match own.problem.into_inner() {
            Some(problem) => return Err(problem),
            None => checked("the function that makes a controller", code)?,
        }
        Ok(Own {
            c,
            heard: Vec::new(),
            extra: Extra::default(),
        })
    });
    c_int::from(code)
}
