//! Nothing, in the place of `bindgen`.
//!
//! `iceoryx2-pal-posix` and `iceoryx2-pal-os-api` name bindgen among the dependencies of their build, but call it where the
//! build runs on QNX alone. The real one needs 12 packages that nothing else does. On QNX, remove
//! the line under `[patch.crates-io]`.
