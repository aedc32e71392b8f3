//! Errors about files and folders that are no logs: what they are, and what to do about it.

use super::format::Probe;
use super::formats::FORMATS;
use super::input::Input;
use super::table;
use super::table::separator::Separator;
use super::values::quote;
use crate::Error;
use std::path::Path;

/// The number of a folder's files that are examined.
const MAX_FILES: usize = 200;
/// The number of a folder's logs that a message names.
const MAX_NAMED: usize = 8;

/// A row with this many numbers holds a laser's beams.
const MIN_BEAMS: usize = 16;

const BAG: &str = "bags aren't read: write their topics as text, rostopic echo -p -b FILE /scan > scan.csv and the same of /odom > \
                   odom.csv, then map scan.csv --poses odom.csv";
const BAG2: &str = "bags aren't read: play it (ros2 bag play FOLDER) and write its topics as text, ros2 topic echo --csv --full-length \
                    /scan > scan.csv and the same of /odom > odom.csv, then map scan.csv --poses odom.csv";
const UNPACK: &str = "unpack it first (gzip is unpacked on the fly)";
const POINTS: &str = "a cloud of points has no sensor poses: map the log that it was made of";
const TABLE: &str = "write it as CSV, and name its columns with --columns";
const NO_LOG: &str = "it is no log of a robot's readings";

/// The first bytes of files that are no logs, their types, and what to do about them.
const SIGNATURES: &[(&[u8], &str, &str)] = &[
    (b"#ROSBAG V", "a ROS 1 bag", BAG),
    (b"\x89MCAP0\r\n", "an MCAP file (a ROS 2 bag)", BAG2),
    (b"SQLite format 3\0", "an SQLite database (as ROS 2 bags are, .db3)", BAG2),
    (b"\x89HDF\r\n", "an HDF5 file", "if it is a MATLAB log, load it in MATLAB and save it with save(name, '-v7')"),
    (
        b"Octave-1-",
        "an Octave file in Octave's binary form",
        "load it in Octave and save it with save -text or save -v7",
    ),
    (b"\x0a\x0d\x0d\x0a", "a capture of network packets (pcapng)", "convert it with the laser's own tools to CSV"),
    (b"\xd4\xc3\xb2\xa1", "a capture of network packets (PCAP)", "convert it with the laser's own tools to CSV"),
    (b"\xa1\xb2\xc3\xd4", "a capture of network packets (PCAP)", "convert it with the laser's own tools to CSV"),
    (b"\x4d\x3c\xb2\xa1", "a capture of network packets (PCAP)", "convert it with the laser's own tools to CSV"),
    (b"# .PCD", "a PCD file", POINTS),
    (b"VERSION .7\nFIELDS", "a PCD file", POINTS),
    (b"ply\n", "a PLY file", POINTS),
    (b"ply\r\n", "a PLY file", POINTS),
    (b"LASF", "a LAS or LAZ file", POINTS),
    (b"PAR1", "a Parquet file", TABLE),
    (b"ARROW1", "an Arrow (Feather) file", TABLE),
    (
        b"\x93NUMPY",
        "a NumPy array (.npy)",
        "write it as text, numpy.savetxt(name, array), and name its columns with --columns",
    ),
    (b"\x89PNG\r\n", "a PNG picture", NO_LOG),
    (b"\xff\xd8\xff", "a JPEG picture", NO_LOG),
    (b"GIF8", "a GIF picture", NO_LOG),
    (b"P5\n", "a PGM picture", "a map, perhaps: echogrid compare and score read those with their .yaml"),
    (b"%PDF", "a PDF document", NO_LOG),
    (b"\x7fELF", "a program", NO_LOG),
    (b"MZ", "a program", NO_LOG),
    (b"\xfd7zXZ", "packed with xz", UNPACK),
    (b"BZh", "packed with bzip2", UNPACK),
    (b"\x28\xb5\x2f\xfd", "packed with zstd", UNPACK),
    (b"7z\xbc\xaf\x27\x1c", "packed with 7z", UNPACK),
    (b"\x04\x22\x4d\x18", "packed with lz4", UNPACK),
];

/// The error about a file whose first bytes show that it is no log.
pub(super) fn binary(path: &Path, head: &[u8]) -> Option<Error> {
    let is = |name: &str, remedy: &str| Some(Error::input(path, format!("is {name}: {remedy}")));
    if utf16(head) {
        return is(
            "UTF-16 text, as Windows writes it",
            "save it as UTF-8 (iconv -f UTF-16 -t UTF-8 OLD > NEW, or in the editor or Excel's \"CSV UTF-8\")",
        );
    }
    let short = head.len() < 4;
    if let Some((_, name, remedy)) = SIGNATURES.iter().find(|(magic, ..)| head.starts_with(magic) && !short) {
        // Two letters alone may begin a text too.
        let text = head.iter().take(512).all(|b| matches!(b, 9..=13 | 32..=126)) && *name == "a program";
        if !text {
            return is(name, remedy);
        }
    }
    let first = head.get(..head.len().min(128)).unwrap_or_default();
    let has = |word: &[u8]| first.windows(word.len()).any(|w| w == word);
    if head.starts_with(b"PK\x03\x04") {
        if has(b"[Content_Types].xml") || has(b"xl/") || has(b"_rels/") || has(b"mimetypeapplication") {
            return is(
                "a workbook or a document (.xlsx, .ods, .docx)",
                "save the sheet as CSV, and name its columns with --columns",
            );
        }
        return match has(b".npy") {
            true => is(
                "NumPy arrays (.npz)",
                "write them as text, numpy.savetxt(name, array), and name the columns with --columns",
            ),
            false => is("packed with zip", UNPACK),
        };
    }
    if head.get(257..262) == Some(b"ustar") {
        return is("packed with tar", UNPACK);
    }
    let mrpt = [&b"CSensoryFrame"[..], b"CActionCollection", b"CObservation", b"CRawlog"];
    if head.contains(&0) && mrpt.iter().any(|class| has(class)) {
        return is(
            "an MRPT rawlog",
            "rawlogs aren't read: export it as text (rawlog-edit --export-2d-scans-txt, --export-odometry-txt), or write JSON Lines \
             (docs/formats.md)",
        );
    }
    None
}

/// The type of a text that is no log, by its content, and what to do about it.
fn kind(text: &str) -> Option<(&'static str, &'static str)> {
    let start = text.trim_start();
    let begins = |word: &str| start.get(..word.len()).is_some_and(|head| head.eq_ignore_ascii_case(word));
    let has = |word: &str| text.lines().take(400).any(|line| line.trim_start().starts_with(word));
    if begins("<!doctype html") || begins("<html") {
        return Some((
            "a web page, as a download that failed leaves it",
            "fetch the file itself again (of GitHub the raw one)",
        ));
    }
    if begins("version https://git-lfs") {
        return Some(("a pointer of Git LFS, not the file", "fetch the file itself (git lfs pull)"));
    }
    if has("stamp:") && (has("angle_min:") || has("ranges:") || has("range:") || has("pose:")) {
        return Some((
            "a ROS topic echoed as YAML",
            "write it as CSV: rostopic echo -p /scan > scan.csv, or ros2 topic echo --csv --full-length /scan > scan.csv, the same of \
             /odom, then map scan.csv --poses odom.csv",
        ));
    }
    None
}

fn utf16(head: &[u8]) -> bool {
    if head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff") {
        return true;
    }
    let pairs = head.get(..head.len().min(256)).unwrap_or_default().chunks_exact(2);
    let ascii = |a: u8, zero: u8| zero == 0 && matches!(a, 9..=13 | 32..=126);
    pairs.len() >= 8 && (pairs.clone().all(|p| ascii(p[0], p[1])) || pairs.clone().all(|p| ascii(p[1], p[0])))
}

/// The error about a file or folder of no known format.
pub(super) fn unknown(path: &Path, probe: &Probe<'_>, head: &[u8]) -> Error {
    let known: Vec<&str> = FORMATS.iter().map(|f| f.describe()).collect();
    let known = known.join("; ");
    let text = match probe {
        Probe::Folder(folder) => return Error::input(path, format!("{} Known are: {known}", in_folder(folder))),
        Probe::Text(text) => text,
    };
    let odd = head.iter().filter(|b| **b < 9 || (14..32).contains(*b)).count();
    if odd * 50 > head.len() || head.contains(&0) {
        return Error::input(path, format!("is binary, not a log. Known are: {known}"));
    }
    if let Some((what, remedy)) = kind(text) {
        return Error::input(path, format!("is {what}: {remedy}"));
    }
    let plain = |line: &&str| {
        let line = line.trim();
        !line.is_empty() && !line.starts_with('#') && !line.starts_with('%')
    };
    let line = text.lines().find(plain).or_else(|| text.lines().find(|l| !l.trim().is_empty())).unwrap_or_default();
    let number = text.lines().position(|l| l == line).map_or(1, |i| i as u64 + 1);
    let rows = Separator::of(line);
    let cells = rows.split(line);
    let numbers = cells.iter().filter(|cell| rows.number(cell).is_some()).count();
    let next = text.lines().skip(number as usize).find(plain).unwrap_or_default();
    let below = rows.split(next).iter().filter(|cell| rows.number(cell).is_some()).count();
    let what = format!("is of no known format; line {number} is {}", quote(line));
    if numbers == 0 && cells.len() > 1 && below > 1 {
        return table::columns_needed(path, number, line, "its columns are not those of a log that is known");
    }
    if numbers > 1 {
        let count = cells.len();
        let values: Vec<f64> = cells.iter().filter_map(|cell| rows.number(cell)).collect();
        if let [_, _, _, _, a, b, c, d] = values[..]
            && (a * a + b * b + c * c + d * d - 1.0).abs() < 1e-3
        {
            let what = "looks like poses with quaternions (TUM: t x y z qx qy qz qw), not like a log: give it by --poses beside the log \
                        whose poses it holds";
            return Error::input(path, what);
        }
        let example = match count {
            2 => "angle:deg,range beside --poses FILE".into(),
            3 => "t,range,- beside --poses FILE".into(),
            4 => "x,y,heading,range".into(),
            5 => "t,x,y,heading,range".into(),
            _ if count < MIN_BEAMS => format!("t,x,y,heading,range,-*{}", count - 5),
            _ => format!("t,x,y,heading,range*{} --sensor laser --set fov=180deg", count - 4),
        };
        return Error::input(
            path,
            format!(
                "{what}. If it is a table, say what its {count} columns hold, such as --columns {example} (docs/formats.md). Known are: {known}"
            ),
        );
    }
    Error::input(
        path,
        format!(
            "{what}. A table is read with its columns named, --columns t,x,y,heading,range (docs/formats.md). Known are: {known}"
        ),
    )
}

/// A text about a folder that is no log.
fn in_folder(folder: &Path) -> String {
    if folder.join("metadata.yaml").is_file()
        && std::fs::read_to_string(folder.join("metadata.yaml")).is_ok_and(|text| text.contains("rosbag2"))
    {
        return format!("no log in this folder: it is a ROS 2 bag, and {BAG2}.");
    }
    let Ok(entries) = std::fs::read_dir(folder) else { return "no log in this folder.".into() };
    let mut files: Vec<_> = entries.flatten().map(|e| e.path()).filter(|path| path.is_file()).take(MAX_FILES).collect();
    files.sort();
    let recognise = |path: &Path| {
        let head = Input::open(path, None).and_then(|input| input.head()).ok()?;
        if binary(path, &head).is_some() {
            return None;
        }
        let text = String::from_utf8_lossy(&head);
        let format = FORMATS.iter().find(|f| f.sniff(&Probe::Text(&text)))?;
        Some(format!("{} ({})", path.file_name()?.to_string_lossy(), format.name()))
    };
    let logs: Vec<String> = files.iter().filter_map(|path| recognise(path)).collect();
    let more = if logs.len() > MAX_NAMED { ", …" } else { "" };
    let named = logs.iter().take(MAX_NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
    match logs.len() {
        0 if files.is_empty() => "no log in this folder: it holds no file.".into(),
        0 => format!("no log in this folder: none of its {} files is one.", files.len()),
        1 => format!("no log in this folder as a whole, but one file is a log: give {named}."),
        n => format!("no log in this folder as a whole, but {n} files are logs: give one of them, {named}{more}."),
    }
}
