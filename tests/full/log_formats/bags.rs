//! MCAP files, as ROS 2 records them: which topic, which field, which time; and what is wrong with them.

use gearwise::measured::{Bench, Channel};

use super::write::{Cdr, Chunks, JOINT_STATE, Mcap, joint_state};
use super::{outcome, refused};

/// A joint whose current, called effort, and motion are in one topic, and the torque of a sensor in another.
const BENCH: &str = r#"actuator = { motor = "t-motor-ri50", ratio = 9 }
kind = "dynamometer"
[columns]
time = { name = "/joint_states/header/stamp", unit = "s" }
current = { name = "/joint_states/effort/knee", unit = "A", convention = "q_axis" }
velocity = { name = "/joint_states/velocity/knee", unit = "rad/s", side = "motor" }
torque = { name = "/sensor/data", unit = "N*m", side = "output" }
[[log]]
file = "log.csv"
"#;

const START: u64 = 1_700_000_000_000_000_000;
const MS: u64 = 1_000_000;

fn good(bench: &str, log: &[u8]) -> Bench {
    outcome(bench, "log.mcap", log).unwrap_or_else(|e| panic!("{e}"))
}

fn bad(bench: &str, log: &[u8], parts: &[&str]) {
    refused(bench, "log.mcap", log, parts);
}

/// Five messages of a leg, one of a gripper between them, and a sensor that is twice as fast.
fn leg() -> Mcap {
    let mut file = Mcap::default();
    let states = file.topic("/joint_states", "sensor_msgs/msg/JointState", "ros2msg", JOINT_STATE, "cdr");
    let sensor = file.topic("/sensor", "std_msgs/msg/Float64", "ros2msg", "float64 data\n", "cdr");
    for k in 0..5_u64 {
        let time = START + 10 * MS * k;
        let x = k as f64;
        // The order of the joints is another in every second message.
        let (names, two) = if k % 2 == 0 { (["hip", "knee"], [-x, x]) } else { (["knee", "hip"], [x, -x]) };
        file.message(
            states,
            time + MS,
            &joint_state(time, &names, &two, &two.map(|v| 10.0 * v), &two.map(|v| 100.0 + v)),
        );
        if k == 2 {
            file.message(states, time + 2 * MS, &joint_state(time + MS, &["gripper"], &[0.5], &[], &[]));
        }
        for half in 0..2 {
            let value = Cdr::default().float(x + 0.5 * f64::from(half)).message();
            file.message(sensor, time + MS + 5 * MS * u64::try_from(half).unwrap(), &value);
        }
    }
    file
}

#[test]
fn a_joint_is_found_by_its_name_in_every_message() {
    for chunks in [Chunks::No, Chunks::Plain, Chunks::Lz4, Chunks::Zstd] {
        let bench = good(BENCH, &leg().file(chunks));
        let log = &bench.logs[0];
        assert_eq!(log.time, [0.0, 0.01, 0.02, 0.03, 0.04], "{chunks:?}");
        assert_eq!(log.channel(Channel::MotorVelocity), Some(&[0.0, 10.0, 20.0, 30.0, 40.0][..]));
        assert_eq!(log.channel(Channel::Current), Some(&[100.0, 101.0, 102.0, 103.0, 104.0][..]));
        assert_eq!(log.channel(Channel::Torque), Some(&[0.0, 1.0, 2.0, 3.0, 4.0][..]));
        assert_eq!(
            log.remarks,
            ["`torque` is of another topic than `time`: each row has its latest value, at most 0 s old"]
        );
    }
}

#[test]
fn the_time_that_is_named_is_the_time() {
    let named = |time: &str| good(&BENCH.replace("/joint_states/header/stamp", time), &leg().file(Chunks::No));
    let log_time = named("/joint_states/log_time");
    assert_eq!(log_time.logs[0].time, [0.0, 0.01, 0.02, 0.03, 0.04]);
    assert_eq!(named("/joint_states/publish_time").logs[0].time, log_time.logs[0].time);
    // The rows are those of the topic that has the time.
    let sensor = named("/sensor/log_time");
    assert_eq!(sensor.logs[0].time.len(), 10);
    let velocity = sensor.logs[0].channel(Channel::MotorVelocity).unwrap();
    assert_eq!(velocity, [0.0, 0.0, 10.0, 10.0, 20.0, 20.0, 30.0, 30.0, 40.0, 40.0]);
    assert!(sensor.logs[0].remarks[0].ends_with("at most 0.005 s old"), "{:?}", sensor.logs[0].remarks);
    // A topic that comes later than the first row leaves it without a value.
    let later = BENCH.replace("/joint_states/header/stamp", "/joint_states/log_time");
    let mut file = leg();
    let late = file.topic("/late", "std_msgs/msg/Float64", "ros2msg", "float64 data\n", "cdr");
    file.message(late, START + 25 * MS, &Cdr::default().float(7.0).message());
    let torque = good(&later.replace("/sensor/data", "/late/data"), &file.file(Chunks::No)).logs[0]
        .channel(Channel::Torque)
        .unwrap()
        .to_vec();
    assert!(torque[..3].iter().all(|v| v.is_nan()) && torque[3..] == [7.0, 7.0]);
    bad(
        &BENCH.replace("stamp\", unit = \"s\"", "stamp\", unit = \"ms\""),
        &leg().file(Chunks::No),
        &["`/joint_states/header/stamp` counts in seconds", "unit = \"s\""],
    );
    bad(
        &BENCH.replace("/sensor/data", "/sensor/log_time"),
        &leg().file(Chunks::No),
        &["column `/sensor/log_time`: it holds the times of its messages"],
    );
    // Messages that were written out of order are put in order.
    let mut swapped = Mcap::default();
    let states = swapped.topic("/joint_states", "sensor_msgs/msg/JointState", "ros2msg", JOINT_STATE, "cdr");
    for k in [1_u64, 0, 3, 2] {
        let x = [k as f64];
        swapped.message(states, START + k * MS, &joint_state(START + k * MS, &["knee"], &x, &x, &x));
    }
    let bench = BENCH.replace("/sensor/data", "/joint_states/position/knee");
    assert_eq!(good(&bench, &swapped.file(Chunks::Zstd)).logs[0].time, [0.0, 0.001, 0.002, 0.003]);
}

#[test]
fn a_wrong_name_lists_those_that_exist() {
    let log = leg().file(Chunks::Zstd);
    bad(
        &BENCH.replace("velocity/knee", "velocity/ankle_pitch_of_the_left_leg"),
        &log,
        &[
            "there is no column `/joint_states/velocity/ankle_pitch_of_the_left_leg` in",
            "/joint_states/velocity/hip",
            "/sensor/data",
            "/sensor/log_time",
            "bench.toml:7",
        ],
    );
    bad(&BENCH.replace("velocity/knee", "velocity/kneee"), &log, &["did you mean `/joint_states/velocity/knee`?"]);
    bad(&BENCH.replace("\"/sensor", "\"/sensors"), &log, &["did you mean `/sensor/data`?"]);
    // A field of lists is no column.
    bad(&BENCH.replace("velocity/knee", "velocity"), &log, &["there is no column `/joint_states/velocity`"]);
    bad(
        &BENCH.replace("/sensor/data", "/joint_states/header/frame_id"),
        &log,
        &["it holds texts, not numbers: `base`"],
    );
    bad(BENCH, &Mcap::default().file(Chunks::No), &["there is no column `/joint_states/header/stamp`"]);
}

#[test]
fn json_is_read_and_other_encodings_are_refused_by_name() {
    let mut file = Mcap::default();
    let topic = file.topic("/drive", "drive", "jsonschema", "{\"type\": \"object\"}", "json");
    for k in 0..4 {
        let text = format!(
            "{{\"stamp\": {{\"sec\": 5, \"nsec\": {}}}, \"motors\": [{{\"i\": {k}.5, \"w\": {k}}}], \"tau\": null}}",
            k * 1_000_000
        );
        file.message(topic, START + k * MS, text.as_bytes());
    }
    let bench = BENCH
        .replace("/joint_states/header/stamp", "/drive/stamp")
        .replace("/joint_states/effort/knee", "/drive/motors/0/i")
        .replace("/joint_states/velocity/knee", "/drive/motors/0/w")
        .replace("/sensor/data", "/drive/motors/0/w");
    let read = good(&bench, &file.file(Chunks::Lz4));
    assert_eq!(read.logs[0].time, [0.0, 0.001, 0.002, 0.003]);
    assert_eq!(read.logs[0].channel(Channel::Current), Some(&[0.5, 1.5, 2.5, 3.5][..]));
    bad(
        &bench.replace("torque = { name = \"/drive/motors/0/w", "torque = { name = \"/drive/tau"),
        &file.file(Chunks::No),
        &["needs `torque`"],
    );
    for (language, encoding, parts) in [
        (
            "protobuf",
            "protobuf",
            ["topic `/sensor`: its messages are encoded as \"protobuf\"", "mcap cat LOG.mcap --topics /sensor --json"],
        ),
        ("flatbuffer", "flatbuffer", ["topic `/sensor`: its messages are encoded as \"flatbuffer\"", "to_parquet"]),
        ("ros2idl", "cdr", ["topic `/sensor`: its messages are described in \"ros2idl\"", "ros2msg"]),
        ("ros2msg", "cdr", ["topic `/sensor`: its messages cannot be read: `nonsense` is no field", "mcap cat"]),
    ] {
        let mut file = leg();
        let used = BENCH.replace("/sensor/data", "/sensor2/data");
        let other = file.topic("/sensor2", "a/b", language, "nonsense", encoding);
        file.message(other, START, &[1, 2, 3]);
        bad(
            &used,
            &file.file(Chunks::No),
            &parts.map(|p| p.replace("/sensor", "/sensor2")).each_ref().map(String::as_str),
        );
        // It does no harm where nothing is asked of it.
        good(BENCH, &file.file(Chunks::No));
    }
    // A recording of ROS 1, as `mcap convert` makes it.
    let mut old = Mcap::default();
    let definition = "Header header\nfloat64[] v\n===\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";
    let topic = old.topic("/drive", "a/B", "ros1msg", definition, "ros1");
    for k in 0..3_u32 {
        let mut data =
            [k.to_le_bytes(), 5_u32.to_le_bytes(), (k * 1_000_000).to_le_bytes(), 1_u32.to_le_bytes()].concat();
        data.push(b'b');
        data.extend(1_u32.to_le_bytes());
        data.extend(f64::from(k).to_le_bytes());
        old.message(topic, START + u64::from(k) * MS, &data);
    }
    let bench = BENCH
        .replace("/joint_states/header/stamp", "/drive/header/stamp")
        .replace("/joint_states/effort/knee", "/drive/v/0")
        .replace("/joint_states/velocity/knee", "/drive/v/0")
        .replace("/sensor/data", "/drive/v/0");
    let read = good(&bench, &old.file(Chunks::Plain));
    assert_eq!(
        (&read.logs[0].time[..], read.logs[0].channel(Channel::Torque)),
        (&[0.0, 0.001, 0.002][..], Some(&[0.0, 1.0, 2.0][..]))
    );
}

#[test]
fn what_is_packed_otherwise_or_no_mcap_file_is_refused_with_the_line_that_converts_it() {
    bad(BENCH, &leg().file(Chunks::Unknown), &["its chunks are compressed as \"xz\"", "mcap decompress"]);
    refused(
        BENCH,
        "log.db3",
        b"SQLite format 3\0\x10\0",
        &["a ROS 2 bag in SQLite (.db3)", "mcap convert LOG.db3 log.mcap"],
    );
    refused(BENCH, "log.bag", b"#ROSBAG V2.0\n", &["a ROS 1 bag", "mcap convert LOG.bag log.mcap"]);
    refused(BENCH, "log.mcap.zstd", b"\x28\xb5\x2f\xfd\0\0", &["zstd has compressed", "zstd -d"]);
    refused(BENCH, "log.csv", &leg().file(Chunks::No), &["this is an MCAP file, not a CSV file", "end in .mcap"]);
    bad(BENCH, b"t,i\n1,2\n", &["this is not an MCAP file, as its name says"]);
}

/// Wherever a file is cut off, and whichever byte is another: an error with its file, or what was there.
#[test]
fn a_damaged_recording_is_refused_or_read_as_it_was() {
    let expected = good(BENCH, &leg().file(Chunks::Lz4)).logs[0].channels.clone();
    for chunks in [Chunks::No, Chunks::Lz4, Chunks::Zstd] {
        let log = leg().file(chunks);
        for cut in (0..log.len()).step_by(41) {
            bad(BENCH, &log[..cut], &["log.mcap"]);
        }
        for at in (0..log.len()).step_by(29) {
            let mut changed = log.clone();
            changed[at] ^= 0x55;
            match outcome(BENCH, "log.mcap", &changed) {
                Err(report) => assert!(report.contains("log.mcap") && report.len() < 20_000, "{report}"),
                // A chunk has a sum of its content; what is in none has not.
                Ok(bench) if chunks != Chunks::No => {
                    assert_eq!(bench.logs[0].channels, expected, "{chunks:?}, byte {at}")
                }
                Ok(_) => {}
            }
        }
    }
}

#[test]
fn a_topic_that_nobody_asks_for_may_be_described_as_it_likes() {
    let mut file = leg();
    // 3^31 paths through 32 messages; elements without bytes; an array of arrays of arrays.
    let next = |k: usize| (0..3).map(|j| format!("M{} f{j}\n", k + 1)).collect::<String>();
    let inner = |k: usize| format!("===\nMSG: p/M{k}\n{}", if k < 31 { next(k) } else { "Empty[1048576] x\n".into() });
    let wide = next(0) + &(1..32).map(inner).collect::<String>() + "===\nMSG: p/Empty\n";
    let empty = "Empty[1048576] a\nEmpty[1048576] b\n===\nMSG: p/Empty\n";
    let nested = format!("float64{} x\n", "[]".repeat(100_000));
    for (topic, definition) in [("/wide", &*wide), ("/empty", empty), ("/nested", &*nested)] {
        let channel = file.topic(topic, "p/M0", "ros2msg", definition, "cdr");
        file.message(channel, START, &Cdr::default().whole(0).message());
    }
    let (found, own) = (good(BENCH, &file.file(Chunks::Plain)), good(BENCH, &leg().file(Chunks::Plain)));
    assert_eq!(found.logs[0].channels, own.logs[0].channels);
    assert_eq!(found.logs[0].time, own.logs[0].time);
}
