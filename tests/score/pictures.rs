//! The pictures of ROS maps: PNG of every kind, PGM and PPM of every maxval, and those that are damaged or too large.

use crate::ros::{CLASSES, PIXELS, YAML, classes, open, place};
use echogrid::ErrorKind;
use png::{BitDepth, ColorType};
use std::path::Path;

/// Writes a PNG of 4 × 3 pixels.
fn png(
    path: &Path,
    colour: ColorType,
    depth: BitDepth,
    bytes: &[u8],
    more: impl Fn(&mut png::Encoder<'_, std::fs::File>),
) {
    let mut encoder = png::Encoder::new(std::fs::File::create(path).unwrap(), 4, 3);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    more(&mut encoder);
    encoder.write_header().unwrap().write_image_data(bytes).unwrap();
}

/// The classes of a map with that picture.
fn with(folder: &Path, mode: &str) -> Vec<i8> {
    let text = format!("{}mode: {mode}\n", YAML.replace("a.pgm", "a.png"));
    classes(&open(folder, text).unwrap().map)
}

#[test]
fn png_of_every_kind() {
    let place = place();
    let folder = place.path();
    let path = folder.join("a.png");
    let each = |of: &dyn Fn(u8) -> Vec<u8>| PIXELS.iter().flat_map(|v| of(*v)).collect::<Vec<u8>>();
    let plain = |_: &mut png::Encoder<'_, std::fs::File>| {};
    png(&path, ColorType::Grayscale, BitDepth::Eight, &PIXELS, plain);
    assert_eq!(with(folder, "trinary"), CLASSES);
    png(&path, ColorType::Rgb, BitDepth::Eight, &each(&|v| vec![v; 3]), plain);
    assert_eq!(with(folder, "trinary"), CLASSES);
    // colours are averaged
    let coloured = each(&|v| vec![v.saturating_sub(30), v, v.saturating_add(30).min(254)]);
    png(&path, ColorType::Rgb, BitDepth::Eight, &coloured, plain);
    assert_eq!(with(folder, "trinary")[5..8], [-1, 1, 0]);
    png(&path, ColorType::Grayscale, BitDepth::Sixteen, &each(&|v| vec![v, v]), plain);
    assert_eq!(with(folder, "trinary"), CLASSES);
    // in 16 bits 0.6501 and 0.6499 are told apart
    let fine: Vec<u8> = [22_930u16, 22_940].iter().cycle().take(12).flat_map(|v| v.to_be_bytes()).collect();
    png(&path, ColorType::Grayscale, BitDepth::Sixteen, &fine, plain);
    assert_eq!(with(folder, "trinary")[..2], [1, 0]);
    png(&path, ColorType::Rgb, BitDepth::Sixteen, &each(&|v| vec![v; 6]), plain);
    assert_eq!(with(folder, "trinary"), CLASSES);
    // a palette, and one pixel to a bit
    let colours: Vec<u8> = PIXELS.iter().flat_map(|v| [*v; 3]).collect();
    let order: Vec<u8> = (0..12).collect();
    png(&path, ColorType::Indexed, BitDepth::Eight, &order, |e| e.set_palette(colours.clone()));
    assert_eq!(with(folder, "trinary"), CLASSES);
    png(&path, ColorType::Grayscale, BitDepth::One, &[0b1000_0000, 0b0100_0000, 0b0010_0000], plain);
    assert_eq!(with(folder, "trinary"), [1, 1, -1, 1, 1, -1, 1, 1, -1, 1, 1, 1]);
}

#[test]
fn alpha_as_map_server_takes_it() {
    let place = place();
    let folder = place.path();
    let path = folder.join("a.png");
    // the first pixel of the bottom row shines through
    let alpha = |k: usize| if k == 8 { 0 } else { 255 };
    let two: Vec<u8> = PIXELS.iter().enumerate().flat_map(|(k, v)| [*v, alpha(k)]).collect();
    let four: Vec<u8> = PIXELS.iter().enumerate().flat_map(|(k, v)| [*v, *v, *v, alpha(k)]).collect();
    // trinary averages the alpha in: 205 is free then, 89 is nothing
    let averaged = [0, -1, -1, 0, -1, -1, 1, 0, 1, -1, -1, 0];
    let wide: Vec<u8> = four.iter().flat_map(|v| [*v, *v]).collect();
    let kinds = [
        (ColorType::GrayscaleAlpha, BitDepth::Eight, &two),
        (ColorType::Rgba, BitDepth::Eight, &four),
        (ColorType::Rgba, BitDepth::Sixteen, &wide),
    ];
    for (colour, depth, bytes) in kinds {
        png(&path, colour, depth, bytes, |_| {});
        assert_eq!(with(folder, "trinary"), averaged, "{colour:?} {depth:?}");
        // scale and raw don't; in scale what isn't opaque is unknown
        assert_eq!(with(folder, "scale"), [0, -1, -1, 1, -1, -1, 1, 0, 1, -1, -1, 0], "{colour:?} {depth:?}");
        let text = format!("{}mode: scale\n", YAML.replace("a.pgm", "a.png"));
        let map = open(folder, text).unwrap().map;
        let touched = &map.layer("touched").unwrap().data;
        assert_eq!((0..12).filter(|k| touched.get(*k) == 0.0).collect::<Vec<_>>(), [0], "{colour:?} {depth:?}");
        assert_eq!(with(folder, "raw")[3], 1, "{colour:?} {depth:?}");
    }
    // a palette with a colour that shines through
    let colours: Vec<u8> = PIXELS.iter().flat_map(|v| [*v; 3]).collect();
    let order: Vec<u8> = (0..12).collect();
    png(&path, ColorType::Indexed, BitDepth::Eight, &order, |e| {
        e.set_palette(colours.clone());
        e.set_trns((0..12).map(alpha).collect::<Vec<u8>>());
    });
    assert_eq!(with(folder, "trinary"), averaged);
}

/// The classes of a map whose picture is these bytes, or what is said of it.
fn pgm(folder: &Path, bytes: &[u8]) -> Result<Vec<i8>, String> {
    std::fs::write(folder.join("a.pgm"), bytes).unwrap();
    match open(folder, YAML) {
        Ok(ros) => Ok(classes(&ros.map)),
        Err(e) => {
            assert!(e.kind() == ErrorKind::Input && e.to_string().contains("a.pgm: "), "{e}");
            Err(e.to_string())
        }
    }
}

#[test]
fn pgm_and_ppm_of_every_maxval() {
    let place = place();
    let folder = place.path();
    let text = |kind: &str, top: u32, of: &dyn Fn(u32) -> String| {
        let samples: Vec<String> = PIXELS.iter().map(|v| of(u32::from(*v))).collect();
        format!("{kind} # a comment\n# another\n4\t3 {top}\n{}\n", samples.join("\n")).into_bytes()
    };
    assert_eq!(pgm(folder, &text("P2", 255, &|v| v.to_string())), Ok(CLASSES.to_vec()));
    assert_eq!(pgm(folder, &text("P2", 510, &|v| format!("{} # twice", 2 * v))), Ok(CLASSES.to_vec()));
    assert_eq!(pgm(folder, &text("P2", 65025, &|v| (255 * v).to_string())), Ok(CLASSES.to_vec()));
    assert_eq!(pgm(folder, &text("P3", 255, &|v| format!("{v} {v} {v}"))), Ok(CLASSES.to_vec()));
    // 35 and 36 of 100 are .65, not above it, and .64; 34 is .66: nothing is rounded to a byte
    assert_eq!(pgm(folder, b"P2 3 1 100 35 36 34"), Ok(vec![0, 0, 1]));
    assert_eq!(pgm(folder, b"P5 3 1 100\n\x23\x24\x22"), Ok(vec![0, 0, 1]));
    assert_eq!(pgm(folder, b"P2\n2 1\n1\n0 1"), Ok(vec![1, -1]));
    let wide: Vec<u8> = PIXELS.iter().flat_map(|v| [*v, *v]).collect();
    assert_eq!(pgm(folder, &[&b"P5 4 3 65535\n"[..], &wide].concat()), Ok(CLASSES.to_vec()));
    let three: Vec<u8> = PIXELS.iter().flat_map(|v| [*v; 3]).collect();
    assert_eq!(pgm(folder, &[&b"P6\n4 3\n255\n"[..], &three].concat()), Ok(CLASSES.to_vec()));
    assert_eq!(pgm(folder, &[&b"P5\r\n# by hand\r\n4 3\r\n255\r\n"[..], &PIXELS].concat()), Ok(CLASSES.to_vec()));
    // a first pixel that looks like a line's end stays one, and what follows the picture doesn't matter
    assert_eq!(pgm(folder, b"P5 2 1 255\n\n\xfe\n"), Ok(vec![1, -1]));
}

#[test]
fn damaged_pictures_are_refused() {
    let place = place();
    let folder = place.path();
    for (bytes, why) in [
        (&b""[..], "it is no picture that can be read: give a PNG, a PGM"),
        (b"GIF89a", "it is no picture"),
        (b"P4\n8 1\n\xff", "it is no picture"),
        (b"P5", "its header is not P5, width, height"),
        (b"P5\n3", "header"),
        (b"P2\nx 3 255\n", "its header is not P2"),
        (b"P5 0 3 255\n", "header"),
        (b"P5 3 1 0\n", "header"),
        (b"P5 3 1 70000\n", "header"),
        (b"P5 3 1 255", "it ends after 0 of 3 pixels"),
        (b"P5 3 1 255\n\x00", "it ends after 1 of 3 pixels"),
        (b"P5 3 1 300\n\x00\x01\x00", "it ends after 1 of 3 pixels"),
        (b"P6 3 1 255\n\x00\x01\x00\x00", "it ends after 1 of 3 pixels"),
        (b"P2 3 1 255\n0 1", "it ends after 2 of 3 pixels"),
        (b"P2 3 1 255\n0 -1 2", "its pixel 1 is no number"),
        (b"P2 3 1 255\n0 1 256", "its pixel 2 is 256, more than its largest value 255"),
        (b"P5 3 1 100\n\x00\x65\x00", "its pixel 1 is 101, more than its largest value 100"),
        (b"P2 3 1 255\n0 99999999999999999999 1", "its pixel 1 is no number"),
    ] {
        let said = pgm(folder, bytes).unwrap_err();
        assert!(said.contains(why), "{why}: {said}");
    }
    png(&folder.join("whole.png"), ColorType::Grayscale, BitDepth::Eight, &PIXELS, |_| {});
    let whole = std::fs::read(folder.join("whole.png")).unwrap();
    for n in [8, 20, whole.len() / 2, whole.len() - 14] {
        let said = pgm(folder, &whole[..n]).unwrap_err();
        assert!(said.contains("it is damaged"), "{n}: {said}");
    }
    let mut other = whole.clone();
    other[whole.len() - 20] ^= 1;
    assert!(pgm(folder, &other).unwrap_err().contains("it is damaged"));
}

#[test]
fn a_size_that_can_not_be_is_refused_before_memory_is_taken() {
    let place = place();
    let folder = place.path();
    for (bytes, why) in [
        (&b"P5 99999999 1 255\n\x00"[..], "header"),
        (b"P2 16000000 16000000 255\n0", "16000000 × 16000000 pixels"),
        (b"P5 16000000 1000000 255\n\x00", "pixels"),
    ] {
        let said = pgm(folder, bytes).unwrap_err();
        assert!(said.contains(why), "{said}");
    }
    // what might be, elsewhere: this machine's memory decides
    std::fs::write(folder.join("a.pgm"), b"P5 65000 65000 255\n\x00").unwrap();
    let error = open(folder, YAML).unwrap_err();
    let text = error.to_string();
    assert!(
        error.kind() == ErrorKind::Resources && text.contains("a.pgm is too large")
            || text.contains("it ends after 1 of"),
        "{text}"
    );
}
