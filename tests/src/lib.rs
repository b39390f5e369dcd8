//! Golden cases: fixed inputs, one hash a kernel, the same on every target.

#![no_std]
