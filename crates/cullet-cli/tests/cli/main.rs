//! The command from outside: what it writes, says and exits with.

mod cull;
mod diff;
mod exit_codes;
mod outputs;
mod pictures;
mod run;
mod stats;
mod tradeoff;
mod verify;
