//! Sections of a solution file: arrays with a tag, a length and checksums, written and read in blocks, so that
//! nothing is in memory twice.

use super::fault::Fault;
use super::records::Record;
use crc32fast::hash;
use std::io::{self, Read, Write};

/// Bytes read or written at a time, about.
const BLOCK: usize = 1 << 16;

/// Tag, number of records and their checksum.
const HEAD: usize = 4 + 8 + 4;

/// Names a section.
pub(super) type Tag = [u8; 4];

/// Bytes with the checksum (CRC-32 of ISO-HDLC, as in PNG) of them.
pub(super) fn write_sealed(to: &mut dyn Write, bytes: &[u8]) -> io::Result<()> {
    to.write_all(bytes)?;
    to.write_all(&hash(bytes).to_le_bytes())
}

/// Writes a section with `count` records.
pub(super) fn write_section<T: Record>(
    to: &mut dyn Write,
    tag: Tag,
    count: usize,
    records: impl IntoIterator<Item = T>,
) -> io::Result<()> {
    let mut head = tag.to_vec();
    head.extend_from_slice(&(count as u64).to_le_bytes());
    write_sealed(to, &head)?;
    let mut block = vec![0; BLOCK / T::BYTES * T::BYTES];
    let mut sum = crc32fast::Hasher::new();
    let (mut used, mut written) = (0, 0);
    let mut records = records.into_iter();
    loop {
        let record = records.next();
        if used == block.len() || record.is_none() {
            sum.update(&block[..used]);
            to.write_all(&block[..used])?;
            used = 0;
        }
        let Some(record) = record else { break };
        record.put(&mut block[used..used + T::BYTES]);
        used += T::BYTES;
        written += 1;
    }
    debug_assert_eq!(written, count, "section {}", tag.escape_ascii());
    to.write_all(&sum.finalize().to_le_bytes())
}

/// Reads sections one after the other.
#[derive(Debug)]
pub(super) struct Sections<R> {
    source: R,
    /// Bytes up to the end of the file.
    left: u64,
}

impl<R: Read> Sections<R> {
    /// Over a file with so many bytes.
    pub(super) fn new(source: R, length: u64) -> Sections<R> {
        Sections { source, left: length }
    }

    /// Bytes that are not read yet.
    pub(super) fn left(&self) -> u64 {
        self.left
    }

    /// The next bytes.
    pub(super) fn read(&mut self, bytes: &mut [u8]) -> Result<(), Fault> {
        self.left = self.left.checked_sub(bytes.len() as u64).ok_or(Fault::Truncated)?;
        Ok(self.source.read_exact(bytes)?)
    }

    /// The next bytes, if the checksum behind them is theirs.
    pub(super) fn read_sealed(&mut self, bytes: &mut [u8], what: &str) -> Result<(), Fault> {
        self.read(bytes)?;
        self.check(hash(bytes), what)
    }

    /// The checksum of bytes that were read follows them.
    pub(super) fn check(&mut self, found: u32, what: &str) -> Result<(), Fault> {
        let mut written = [0; 4];
        self.read(&mut written)?;
        if u32::from_le_bytes(written) == found {
            return Ok(());
        }
        Err(Fault::Damaged(format!("{what} has not the checksum that it was written with")))
    }

    /// The records of the next section, which must be this one, `most` of them at most. Memory is asked for as they are
    /// read: the length of a file says little of what is in it.
    pub(super) fn section<T: Record>(&mut self, tag: Tag, most: usize) -> Result<Vec<T>, Fault> {
        let name = format!("section {}", tag.escape_ascii());
        let mut head = [0; HEAD - 4];
        self.read_sealed(&mut head, &format!("the head of {name}"))?;
        if head[..4] != tag {
            return Err(Fault::Damaged(format!("{name} is not where it belongs")));
        }
        let count = u64::get(&head[4..]).unwrap_or_default();
        let bytes = count.checked_mul(T::BYTES as u64).filter(|&bytes| bytes <= self.left);
        let mut bytes = bytes.ok_or(Fault::Truncated)?;
        if count > most as u64 {
            return Err(Fault::Damaged(format!("{name} is longer than in any solution of this scene")));
        }
        let mut records: Vec<T> = Vec::new();
        let mut block = vec![0; (BLOCK / T::BYTES * T::BYTES).min(bytes as usize)];
        let mut sum = crc32fast::Hasher::new();
        while bytes > 0 {
            let part = (block.len() as u64).min(bytes) as usize;
            self.read(&mut block[..part])?;
            sum.update(&block[..part]);
            bytes -= part as u64;
            let too_large = |_| Fault::Damaged(format!("{name} does not fit into memory"));
            records.try_reserve(part / T::BYTES).map_err(too_large)?;
            for record in block[..part].chunks_exact(T::BYTES) {
                let record =
                    T::get(record).filter(|next| records.last().is_none_or(|last| next.may_follow(last)));
                let record = record
                    .ok_or_else(|| Fault::Damaged(format!("{name} holds values that no solution has")))?;
                records.push(record);
            }
        }
        self.check(sum.finalize(), &name)?;
        Ok(records)
    }

    /// After the last section nothing may follow.
    pub(super) fn end(&self) -> Result<(), Fault> {
        match self.left {
            0 => Ok(()),
            left => Err(Fault::Damaged(format!("{left} bytes follow its end"))),
        }
    }
}
