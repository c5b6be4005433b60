//! Text of PLY files as the reader of headers and numbers wants it: lines end in LF, numbers have digits on both sides of their
//! point, and what is no ASCII (comments in other encodings) is a question mark. Binary data stays as it is.

use std::io::{self, BufRead, Read};

/// As much of a line of the header as tells what it is.
const LONGEST_STATEMENT: usize = 64;
/// Bytes that are made plain at a time.
const AT_ONCE: usize = 4096;

/// A file of which the text is made plain while it is read.
pub(super) struct PlainText<R> {
    file: R,
    part: Part,
    /// The beginning of the line of the header that is being read; after a CR only that of the last one before binary data.
    line: Vec<u8>,
    is_binary: bool,
    /// Whether lines end in CR and LF: then the LF after the header belongs to it, and otherwise to the data.
    has_both: bool,
    before: Before,
    /// What has been made and not been read yet.
    ready: Vec<u8>,
    read: usize,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Header,
    Text,
    Binary,
}

/// The byte before, as far as it matters to the next one.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Before {
    Other,
    /// CR, for which LF has been given.
    Return,
    Digit,
    /// A point after a digit.
    Point,
}

impl<R: BufRead> PlainText<R> {
    pub(super) fn new(file: R) -> Self {
        PlainText {
            file,
            part: Part::Header,
            line: Vec::new(),
            is_binary: false,
            has_both: false,
            before: Before::Other,
            ready: Vec::new(),
            read: 0,
        }
    }

    /// Takes a byte of the file.
    fn take(&mut self, byte: u8) {
        let before = std::mem::replace(&mut self.before, Before::Other);
        if before == Before::Return && byte == b'\n' && self.part != Part::Binary {
            self.has_both = true;
            if !self.line.is_empty() {
                self.part = Part::Binary;
            }
            return;
        }
        match self.part {
            Part::Header => self.take_of_header(byte),
            Part::Text => self.take_of_numbers(byte, before),
            Part::Binary => self.ready.push(byte),
        }
        if byte == b'\r' && self.part != Part::Binary {
            self.before = Before::Return;
        }
    }

    fn take_of_header(&mut self, byte: u8) {
        self.ready.push(plain(byte));
        if !matches!(byte, b'\r' | b'\n') {
            if self.line.len() < LONGEST_STATEMENT {
                self.line.push(byte);
            }
            return;
        }
        let mut words = self.line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            Some(b"format") => self.is_binary = words.next().is_some_and(|word| word.starts_with(b"binary")),
            Some(b"end_header") if !self.is_binary => self.part = Part::Text,
            // With the LF that follows.
            Some(b"end_header") if byte == b'\r' && self.has_both => return,
            Some(b"end_header") => self.part = Part::Binary,
            _ => {}
        }
        self.line.clear();
    }

    fn take_of_numbers(&mut self, byte: u8, before: Before) {
        let is_digit = byte.is_ascii_digit();
        if before == Before::Point && !is_digit || before != Before::Digit && byte == b'.' {
            self.ready.push(b'0');
        }
        self.ready.push(plain(byte));
        self.before = match byte {
            b'.' if before == Before::Digit => Before::Point,
            _ if is_digit => Before::Digit,
            _ => Before::Other,
        };
    }
}

/// A byte of a text.
fn plain(byte: u8) -> u8 {
    match byte {
        b'\r' => b'\n',
        _ if byte.is_ascii() => byte,
        _ => b'?',
    }
}

impl<R: BufRead> Read for PlainText<R> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        while self.read == self.ready.len() {
            self.ready.clear();
            self.read = 0;
            let bytes = self.file.fill_buf()?;
            let count = bytes.len();
            if count == 0 {
                // A number at the very end.
                if std::mem::replace(&mut self.before, Before::Other) != Before::Point {
                    return Ok(0);
                }
                self.ready.push(b'0');
                break;
            }
            if self.part == Part::Binary {
                let count = count.min(to.len());
                to[..count].copy_from_slice(&bytes[..count]);
                self.file.consume(count);
                return Ok(count);
            }
            let mut some = [0; AT_ONCE];
            let count = count.min(AT_ONCE);
            some[..count].copy_from_slice(&bytes[..count]);
            self.file.consume(count);
            some[..count].iter().for_each(|&byte| self.take(byte));
        }
        let count = to.len().min(self.ready.len() - self.read);
        to[..count].copy_from_slice(&self.ready[self.read..self.read + count]);
        self.read += count;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain_form(file: &[u8]) -> Vec<u8> {
        // However few bytes there are at a time.
        let forms = [1, 2, 7, 8192].map(|size| {
            let mut plain = Vec::new();
            let file = io::BufReader::with_capacity(size, file);
            PlainText::new(file).read_to_end(&mut plain).expect("memory");
            plain
        });
        assert!(forms.iter().all(|form| *form == forms[0]));
        let [form, ..] = forms;
        form
    }

    #[test]
    fn text_is_made_plain_and_data_is_not() {
        let head = |end: &str| {
            ["ply", "format ascii 1.0", "comment caf\u{e9}. .5", "end_header", ""].join(end).into_bytes()
        };
        let numbers = |end: &str| ["-.5 +1. .5e3 1.e-2 1.5 . x", "3 0 1 2.", "7."].join(end).into_bytes();
        let expected = "-0.5 +1.0 0.5e3 1.0e-2 1.5 0. x\n3 0 1 2.0\n7.0";
        for end in ["\n", "\r\n", "\r"] {
            let form = plain_form(&[head(end), numbers(end)].concat());
            assert_eq!(
                String::from_utf8_lossy(&form),
                format!("ply\nformat ascii 1.0\ncomment caf??. .5\nend_header\n{expected}")
            );
            // Data may begin like the end of a line, and look like text.
            for data in [&b"\n\r\n\xe9.5 1.\r"[..], b"\r\r1.", b"end_header\r\n", b""] {
                let binary =
                    String::from_utf8(head(end)).expect("UTF-8").replace("ascii", "binary_little_endian");
                let form = plain_form(&[binary.as_bytes(), data].concat());
                assert!(form.ends_with(&[b"\nend_header\n", data].concat()), "{end:?} {data:?} {form:?}");
            }
        }
    }
}
