//! MATLAB logs, made here byte by byte: every way in which their numbers may be stored, and everything that may be wrong with them.

use echogrid::ErrorKind;
use echogrid::log::reading::Record;
use echogrid::log::{Log, Options, Problem};
use echogrid::sensor::Kind;
use proptest::prelude::*;
use std::io::Write;

/// A data element: its tag, its bytes, padded to eight.
fn element(kind: u32, bytes: &[u8]) -> Vec<u8> {
    let mut all = [kind.to_le_bytes(), (bytes.len() as u32).to_le_bytes()].concat();
    all.extend_from_slice(bytes);
    all.resize(all.len().next_multiple_of(8), 0);
    all
}

/// A small one: up to four bytes in the tag.
fn small(kind: u16, bytes: &[u8]) -> Vec<u8> {
    let mut all = [kind.to_le_bytes(), (bytes.len() as u16).to_le_bytes()].concat();
    all.extend_from_slice(bytes);
    all.resize(8, 0);
    all
}

fn words(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// An array of a class: flags, sizes, name, then what is given.
fn array(class: u32, sizes: [u32; 2], name: &str, rest: &[u8]) -> Vec<u8> {
    let name = if name.len() <= 4 { small(1, name.as_bytes()) } else { element(1, name.as_bytes()) };
    let head = [element(6, &words(&[class, 0])), element(5, &words(&sizes)), name];
    element(14, &[&head.concat(), rest].concat())
}

fn doubles(sizes: [u32; 2], name: &str, values: &[f64]) -> Vec<u8> {
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    array(6, sizes, name, &element(9, &bytes))
}

fn cells(name: &str, cells: &[Vec<u8>]) -> Vec<u8> {
    array(1, [cells.len() as u32, 1], name, &cells.concat())
}

fn structure(name: &str, fields: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let names: Vec<u8> = fields.iter().flat_map(|(n, _)| format!("{n:\0<8}").into_bytes()).collect();
    let values: Vec<u8> = fields.iter().flat_map(|(_, v)| v.clone()).collect();
    array(2, [1, 1], name, &[small(5, &words(&[8])), element(1, &names), values].concat())
}

fn file(variables: &[Vec<u8>]) -> Vec<u8> {
    let mut all = format!("{:<124}", "MATLAB 5.0 MAT-file, made by hand").into_bytes();
    all.extend_from_slice(&[0, 1, b'I', b'M']);
    all.extend(variables.concat());
    all
}

fn packed(variable: &[u8]) -> Vec<u8> {
    let mut pack = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    pack.write_all(variable).unwrap();
    let bytes = pack.finish().unwrap();
    [&words(&[15, bytes.len() as u32]), &bytes[..]].concat()
}

fn poses(x: &[f64], y: &[f64], h: &[f64]) -> Vec<u8> {
    let column = |v: &[f64]| doubles([v.len() as u32, 1], "", v);
    structure("robotPose", &[("x", column(x)), ("y", column(y)), ("h", column(h))])
}

/// Two scans: one of two labelled points, one of one without a label.
fn good() -> [Vec<u8>; 2] {
    let first = doubles([3, 2], "", &[3.0, 4.0, 2.0, 0.0, 1.0, 6.0]);
    let second = doubles([2, 1], "", &[2.0, 0.0]);
    [poses(&[1.0, 5.0], &[2.0, 6.0], &[0.5, 0.0]), cells("laserScan", &[first, second])]
}

fn open(bytes: &[u8]) -> Log {
    Log::read(bytes, &Options::default()).unwrap()
}

fn read(log: &Log) -> Vec<Record> {
    log.records().unwrap().map(|r| r.unwrap()).collect()
}

fn refused(bytes: &[u8]) -> String {
    let error = Log::read(bytes, &Options::default()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Input, "{error}");
    error.to_string()
}

/// Good records, and what is said of the others.
fn pass(log: &Log) -> (usize, Vec<String>) {
    let (good, bad): (Vec<_>, Vec<_>) = log.records().unwrap().partition(Result::is_ok);
    let text = |p: Result<Record, Problem>| p.unwrap_err().to_string();
    (good.len(), bad.into_iter().map(text).collect())
}

#[test]
fn points_become_readings() {
    let log = open(&file(&good()));
    let header = log.header();
    assert_eq!((header.format, header.sensors.len(), header.classes.len()), ("matlab", 1, 6));
    assert_eq!((header.sensors[0].kind, header.classes[0].as_str()), (Kind::Laser, "hallways"));
    let records = read(&log);
    assert_eq!(records.len(), 3);
    let [a, b, c] = records[..] else { panic!("{records:?}") };
    assert_eq!((a.range, a.label, a.scan, a.line), (5.0, Some(2), 0, 1));
    assert!((a.pose.heading - (0.5 + 4f64.atan2(3.0))).abs() < 1e-12 && a.pose.x == 1.0 && a.pose.y == 2.0);
    assert_eq!((b.range, b.label), (1.0, Some(6)));
    assert_eq!((c.range, c.label, c.scan, c.line, c.robot.x), (2.0, None, 1, 2, 5.0));
    // Again, from the start.
    assert_eq!(read(&log).len(), 3);
}

#[test]
fn however_it_is_stored() {
    let plain = read(&open(&file(&good())));
    let same = |bytes: &[u8], what: &str| assert_eq!(read(&open(bytes)), plain, "{what}");
    let [poses_, scans] = good();
    same(&file(&[packed(&poses_), packed(&scans)]), "compressed");
    same(&file(&[doubles([1, 1], "other", &[7.0]), scans.clone(), poses_.clone()]), "in another order, with more");
    // Whole numbers in the smallest type that holds them.
    let bytes = |values: &[u8]| array(6, [values.len() as u32, 1], "", &small(2, values));
    let shorts = element(3, &[5i16, -6, 300].map(i16::to_le_bytes).concat());
    let column = |v: &[f64]| doubles([v.len() as u32, 1], "", v);
    let fields = [
        ("x", bytes(&[1, 5])),
        ("y", bytes(&[2, 6])),
        ("h", column(&[0.5, 0.0])),
        ("odd", array(6, [3, 1], "", &shorts)),
    ];
    same(&file(&[structure("robotPose", &fields), scans]), "small integers");
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gz.write_all(&file(&good())).unwrap();
    same(&gz.finish().unwrap(), "gzip");
}

#[test]
fn what_is_missing_is_named_with_what_is_there() {
    let [poses_, scans] = good();
    let text = refused(&file(std::slice::from_ref(&poses_)));
    let points = "laserScan (a cell of 2 × N or 3 × N points for each scan)";
    assert!(text.ends_with(&format!("has no variable {points}; it holds 'robotPose'")), "{text}");
    let text = refused(&file(&[doubles([1, 1], "speed", &[1.0]), scans.clone()]));
    assert!(
        text.ends_with("has no variable robotPose (a struct of x, y and h); it holds 'speed', 'laserScan'"),
        "{text}"
    );
    let text = refused(&file(&[]));
    assert!(
        text.ends_with(&format!("no variable robotPose (a struct of x, y and h) and no {points}; it holds nothing"))
    );
    let odd: Vec<Vec<u8>> = (0..20).map(|k| doubles([1, 1], &format!("v\u{1b}[31m{k}"), &[1.0])).collect();
    let text = refused(&file(&odd));
    assert!(!text.contains('\u{1b}') && text.contains(" and 4 more. Name them, such as --fields pose="), "{text}");
    let column = |v: &[f64]| doubles([v.len() as u32, 1], "", v);
    let fields = [("x", column(&[1.0])), ("th", column(&[1.0]))];
    let text = refused(&file(&[structure("robotPose", &fields), scans.clone()]));
    assert!(text.ends_with("robotPose has no field y and no h; it has 'x', 'th'"), "{text}");
    let text = refused(&file(&[doubles([1, 2], "robotPose", &[1.0, 2.0]), scans.clone()]));
    assert!(text.ends_with("robotPose is 1 × 2 numbers, not a struct of x, y and h"), "{text}");
    let text = refused(&file(&[poses_, doubles([2, 2], "laserScan", &[1.0; 4])]));
    assert!(text.ends_with("laserScan is 2 × 2 numbers, not a cell of scans"), "{text}");
    let text = refused(&file(&[poses(&[1.0], &[2.0], &[0.0, 1.0]), scans]));
    assert!(text.ends_with("robotPose has 1 x, 1 y and 2 h for 2 scans in laserScan: as many are wanted"), "{text}");
}

#[test]
fn other_versions_say_what_to_do() {
    let hdf5 = format!("{:<512}", "MATLAB 7.3 MAT-file, Platform: GLNXA64");
    let remedy = "load it in MATLAB and save it with save(name, '-v7')";
    assert!(refused(hdf5.as_bytes()).ends_with(remedy));
    assert!(refused(b"\x89HDF\r\n\x1a\n and more").ends_with(remedy));
    let mut turned = file(&good());
    turned[126..128].copy_from_slice(b"MI");
    assert!(refused(&turned).contains("other byte order"));
    let sonar = Options { kind: Some(Kind::Sonar), ..Options::default() };
    let text = Log::read(&file(&good())[..], &sonar).unwrap_err().to_string();
    assert!(text.contains("leave out --sensor sonar"), "{text}");
}

#[test]
fn bad_scans_are_counted_one_by_one() {
    let scans = [
        doubles([2, 1], "", &[2.0, 0.0]),
        doubles([2, 0], "", &[]),
        doubles([4, 1], "", &[1.0, 2.0, 3.0, 4.0]),
        doubles([3, 3], "", &[1.0, 0.0, 1.5, 1.0, 0.0, 0.0, 2.0, 0.0, 3.0]),
        array(4, [1, 1], "", &small(4, &[65, 0])),
        element(14, &[]),
        doubles([2, 1], "", &[2.0, 0.0]),
        doubles([2, 3], "", &[f64::INFINITY, f64::NAN, 1.0, 1.0, 0.0, f64::NEG_INFINITY]),
    ];
    let x = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f64::NAN, 0.0];
    let log = open(&file(&[poses(&x, &[0.0; 8], &[0.0; 8]), cells("laserScan", &scans)]));
    let (good, bad) = pass(&log);
    assert_eq!(good, 3);
    let wanted = [
        "line 3: scan 3: 4 × 1 numbers, not 2 × N or 3 × N points",
        "line 4: scan 4: beam 1: label 1.5: labels are whole numbers from 1",
        "line 4: scan 4: beam 2: label 0: labels are whole numbers from 1",
        "line 5: scan 5: text, not 2 × N or 3 × N points",
        "line 7: scan 7: the robot's x is NaN",
        "line 8: scan 8: beam 1: (inf, NaN) is no point",
        "line 8: scan 8: beam 3: (0, -inf) is no point",
    ];
    assert_eq!(bad, wanted);
}

#[test]
fn other_variables_are_passed_over_whatever_they_are() {
    let plain = read(&open(&file(&good())));
    let [poses_, scans] = good();
    // Large once it is unpacked, damaged in its middle, no array at all.
    let large = packed(&element(14, &vec![0; 40 << 20]));
    let mut damaged = packed(&doubles([1, 3000], "noise", &(0..3000).map(f64::from).collect::<Vec<_>>()));
    let middle = damaged.len() / 2;
    damaged[middle..middle + 40].fill(0xaa);
    let odd = element(3, &[1, 2, 3, 4]);
    assert_eq!(read(&open(&file(&[large, damaged, odd, poses_, scans]))), plain);
}

#[test]
fn a_file_that_takes_too_much_is_refused() {
    let [poses_, _] = good();
    // A thousand times smaller packed: numbers of one byte become eight, and empty cells arrays.
    let bytes = vec![0u8; 70 << 20];
    let numbers = packed(&array(6, [1, 70 << 20], "laserScan", &element(2, &bytes)));
    let cells = packed(&array(1, [9 << 20, 1], "laserScan", &element(14, &[]).repeat(9 << 20)));
    for scans in [numbers, cells] {
        let text = refused(&file(&[poses_.clone(), scans]));
        assert!(text.ends_with("laserScan: is more than 512 MiB to read: save fewer scans in a file"), "{text}");
    }
}

#[test]
fn every_cut_is_refused() {
    for whole in [file(&good()), file(&good().map(|v| packed(&v)))] {
        for end in 20..whole.len() {
            let cut = &whole[..end];
            // Between two variables the file ends as if it had no more.
            let text = refused(cut);
            assert!(
                ["cut off", "header", "no variable", "packed", "damaged"].iter().any(|w| text.contains(w)),
                "{end}: {text}"
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn damage_never_panics(at in 124usize..900, byte in any::<u8>(), more in 0usize..4, compress in any::<bool>()) {
        let mut bytes = if compress { file(&good().map(|v| packed(&v))) } else { file(&good()) };
        for k in 0..=more {
            let place = 124 + (at - 124 + 97 * k) % (bytes.len() - 124);
            bytes[place] ^= byte.rotate_left(k as u32);
        }
        if let Ok(log) = Log::read(&bytes[..], &Options::default()) {
            pass(&log);
        }
    }
}
