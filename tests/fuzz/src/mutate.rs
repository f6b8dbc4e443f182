//! Seeded mutations of inputs: a small stand-in for libFuzzer where only stable Rust is at hand.

use chacha20::ChaCha8Rng;
use rand::{Rng, SeedableRng};

/// Texts that stand at the edges of what readers accept.
const TEXTS: [&str; 24] = [
    "nan",
    "inf",
    "-inf",
    "1e300",
    "1e-300",
    "-1",
    "0",
    "-0.0",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551615",
    "1e999",
    "\"\"",
    "\"\n\"",
    "[",
    "]",
    "{}",
    "[[",
    "=",
    ",",
    "\n",
    "\r\n",
    "\u{feff}",
    "\u{2028}",
];

/// Whole numbers at the edges of their types.
const NUMBERS: [u64; 8] = [
    0,
    1,
    0x7f,
    0xff,
    0x7fff_ffff,
    0xffff_ffff,
    i64::MAX as u64,
    u64::MAX,
];

/// Mutates inputs; the same seed gives the same mutations.
#[derive(Debug)]
pub struct Mutator {
    random: ChaCha8Rng,
}

impl Mutator {
    /// A mutator of this seed.
    pub fn new(seed: u64) -> Self {
        Self {
            random: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// One to four changes to one of the seeds.
    pub fn input(&mut self, seeds: &[Vec<u8>]) -> Vec<u8> {
        let mut input = self.pick(seeds).cloned().unwrap_or_default();
        for _ in 0..=self.below(4) {
            self.change(&mut input, seeds);
        }
        input
    }

    fn change(&mut self, input: &mut Vec<u8>, seeds: &[Vec<u8>]) {
        let (begin, end) = self.range(input.len());
        match self.below(8) {
            0 => input.truncate(end),
            1 => drop(input.drain(begin..end)),
            2 => {
                let copy = input[begin..end].to_vec();
                let at = self.below(input.len() + 1);
                drop(input.splice(at..at, copy));
            }
            3 => {
                let other = self.pick(seeds).cloned().unwrap_or_default();
                let (from, to) = self.range(other.len());
                drop(input.splice(begin..end, other[from..to].iter().copied()));
            }
            4 => {
                let text = TEXTS[self.below(TEXTS.len())];
                drop(input.splice(begin..begin, text.bytes()));
            }
            5 => {
                let text = TEXTS[self.below(TEXTS.len())];
                let (from, to) = word(input, begin);
                drop(input.splice(from..to, text.bytes()));
            }
            6 => {
                let number = NUMBERS[self.below(NUMBERS.len())].to_le_bytes();
                let size = 1 << self.below(4);
                for (byte, new) in input.iter_mut().skip(begin).zip(&number[..size]) {
                    *byte = *new;
                }
            }
            _ => {
                if let Some(byte) = input.get_mut(begin) {
                    *byte ^= 1 << self.below(8);
                }
            }
        }
    }

    /// A number below `limit`; 0 if there is none.
    fn below(&mut self, limit: usize) -> usize {
        (self.random.next_u64() % limit.max(1) as u64) as usize
    }

    fn pick<'a, T>(&mut self, all: &'a [T]) -> Option<&'a T> {
        all.get(self.below(all.len()))
    }

    /// Begin and end of a part of at most 64 bytes.
    fn range(&mut self, length: usize) -> (usize, usize) {
        let begin = self.below(length + 1);
        let end = begin + self.below(65);
        (begin, end.min(length))
    }
}

/// The number or word around a byte.
fn word(input: &[u8], at: usize) -> (usize, usize) {
    let part = |byte: &u8| byte.is_ascii_alphanumeric() || b"+-._".contains(byte);
    let before = input[..at]
        .iter()
        .rev()
        .take_while(|byte| part(byte))
        .count();
    let after = input[at..].iter().take_while(|byte| part(byte)).count();
    (at - before, at + after)
}
