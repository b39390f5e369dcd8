//! Tables in a Markdown document, between two comments.

use crate::{Error, Result};

/// Whether a document has the comment before the contents of this name.
pub fn is_marked(document: &str, name: &str) -> bool {
    document.contains(&begin_of(name))
}

/// Replaces the lines of a document between two comments by `contents`.
///
/// The comments are `<!-- NAME -->` and `<!-- end of NAME -->`. The second gets a checksum of the lines in between, by
/// which manual changes are detected.
///
/// # Errors
/// [`Error::Data`] for a document without one of them.
pub fn rewritten(document: &str, name: &str, contents: &str) -> Result<String> {
    let (begin, end) = (begin_of(name), format!("<!-- end of {name}"));
    let missing = |line: &str| Error::Data(format!("has no line `{}`", line.trim_end()));
    let (before, rest) = document.split_once(&begin).ok_or_else(|| missing(&begin))?;
    let (_, after) = rest.split_once(&end).ok_or_else(|| missing(&end))?;
    let (_, after) = after.split_once("-->").ok_or_else(|| missing(&end))?;
    let between = format!("\n{contents}\n");
    let sum = crc32fast::hash(between.as_bytes());
    Ok(format!(
        "{before}{begin}{between}{end}, {sum:08x} -->{after}"
    ))
}

fn begin_of(name: &str) -> String {
    format!("<!-- {name} -->\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contents_stand_between_their_comments() {
        let document =
            "before\n<!-- a -->\nold\n<!-- end of a -->\nafter\n<!-- b -->\n<!-- end of b -->\n";
        assert!(is_marked(document, "a") && !is_marked(document, "c"));
        // The CRC-32 of ISO 3309 of "\nnew\n", by Python's zlib.
        let expected = "before\n<!-- a -->\n\nnew\n<!-- end of a, 99dc6068 -->\nafter\n<!-- b -->\n<!-- end of b -->\n";
        let once = rewritten(document, "a", "new").unwrap();
        assert_eq!(once, expected);
        let other = rewritten(&once, "a", "other").unwrap();
        assert_ne!(other, once);
        assert_eq!(rewritten(&other, "a", "new").unwrap(), once);
        for wrong in ["nothing", "<!-- a -->\n", "<!-- b -->\n<!-- end of b -->"] {
            assert!(rewritten(wrong, "a", "").is_err(), "{wrong}");
        }
    }
}
