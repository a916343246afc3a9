//! Words that a POSIX shell reads back as they are.

/// A command that can be pasted into a shell.
pub fn command_line(words: &[String]) -> String {
    words.iter().map(|word| quote(word)).collect::<Vec<_>>().join(" ")
}

/// `word` in quotes, if it needs them.
pub(super) fn quote(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    // Nothing is special between single quotes but the quote itself, which has to stand outside.
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    #[test]
    fn plain_words_stay() {
        assert_eq!(quote("--tile=1/2"), "--tile=1/2");
        assert_eq!(quote(""), "''");
        assert_eq!(quote("it's"), r"'it'\''s'");
    }

    /// The shell itself is asked.
    #[test]
    fn a_shell_reads_the_words_back() {
        let words =
            ["a b", "it's", "\"$HOME\"", "`id`", "\\", "", "*", "~", "Größe 円", "#x", "!", "a;b", "{a,b}", "-"];
        let line = format!("printf '<%s>' {}", command_line(&words.map(str::to_owned)));
        for shell in ["sh", "bash"] {
            let output = Command::new(shell).args(["-c", &line]).output().expect("a shell");
            let expected: String = words.iter().map(|word| format!("<{word}>")).collect();
            assert_eq!(String::from_utf8_lossy(&output.stdout), expected, "{shell}");
        }
    }
}
