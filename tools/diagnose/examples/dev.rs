fn main() {
    for path in std::env::args().skip(1) {
        let import = slipstream_recording::read(path.as_ref()).unwrap();
        println!("== {path}");
        if std::env::var("DEV2").is_ok() {
            slipstream_diagnose::dev2(&import.recording, import.recording.model.as_ref().unwrap());
        } else {
            slipstream_diagnose::dev(&import.recording, import.recording.model.as_ref().unwrap());
        }
    }
}
