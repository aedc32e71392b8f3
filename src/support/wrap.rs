//! Text broken into lines of 100 columns.

/// The most columns of a line.
pub(crate) const COLUMNS: usize = 100;

/// A text in lines, broken between words; those after the first are indented. A word longer than a line stays whole.
pub(crate) fn wrap(text: &str, indent: usize) -> String {
    let (mut all, mut column) = (String::new(), 0);
    for (k, word) in text.split(' ').enumerate() {
        let length = word.chars().count();
        if column > indent && column + 1 + length > COLUMNS {
            all += "\n";
            all += &" ".repeat(indent);
            column = indent;
        } else if k > 0 {
            all += " ";
            column += 1;
        }
        all += word;
        column += length;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_broken_between_words() {
        let text = format!("memory    {}{}", "word ".repeat(40), "x".repeat(120));
        let lines: Vec<String> = wrap(&text, 10).lines().map(String::from).collect();
        assert_eq!(lines[0], format!("memory    {}", "word ".repeat(18).trim_end()));
        assert!(lines[1].starts_with("          word word") && lines[1].len() <= COLUMNS);
        assert_eq!(lines.last().unwrap().trim_start(), "x".repeat(120));
        assert_eq!((wrap("short", 4), wrap("  short", 4)), ("short".into(), "  short".into()));
        let indented = wrap(&format!("          {}", "word ".repeat(40)), 10);
        assert!(indented.lines().all(|l| l.starts_with("          word")), "{indented}");
    }
}
