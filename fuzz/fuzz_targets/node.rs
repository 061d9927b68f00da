#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| slqg_properties::node::check(bytes));
