#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| gearwise_fuzz::bodies::run("npz", bytes));
