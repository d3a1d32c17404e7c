//! Serialisation of the frozen basis: versioned, little-endian, complete.

use super::{Basis, BasisError, ModeSet};
use bladeoff_numerics::linalg::Matrix;

const MAGIC: &[u8; 8] = b"BLADEBAS";
const VERSION: u32 = 1;
/// Largest accepted number of rows or columns.
const LARGEST: u64 = 1 << 20;

impl Basis {
    /// Serialises the basis; equal bases give equal bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Vec::new();
        out.extend_from_slice(MAGIC);
        out.extend_from_slice(&VERSION.to_le_bytes());
        out.extend_from_slice(&self.key);
        out.extend_from_slice(&(self.rings.len() as u64).to_le_bytes());
        for set in [&self.lateral, &self.torsion].into_iter().chain(&self.rings) {
            out.extend_from_slice(&(set.shapes.nrows() as u64).to_le_bytes());
            out.extend_from_slice(&(set.shapes.ncols() as u64).to_le_bytes());
            for value in [set.full_limit].iter().chain(&set.omega_squared).chain(set.shapes.as_slice()) {
                out.extend_from_slice(&value.to_le_bytes());
            }
        }
        out
    }

    /// Reads bytes written by [`Basis::to_bytes`].
    ///
    /// # Errors
    /// [`BasisError::Malformed`] with the byte offset. Bytes that are not a basis never cause a panic or a large allocation.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, BasisError> {
        let mut reader = Reader { bytes, at: 0 };
        if reader.take(8)? != MAGIC {
            return Err(reader.wrong("the magic number is missing"));
        }
        if u32::from_le_bytes(reader.array()?) != VERSION {
            return Err(reader.wrong("another version"));
        }
        let key = reader.array()?;
        let rings = reader.size()?;
        if rings > 1024 {
            return Err(reader.wrong("too many rings"));
        }
        let lateral = reader.mode_set()?;
        let torsion = reader.mode_set()?;
        let rings = (0..rings).map(|_| reader.mode_set()).collect::<Result<Vec<_>, _>>()?;
        if reader.at != bytes.len() {
            return Err(reader.wrong("bytes behind the end"));
        }
        Ok(Self { key, lateral, torsion, rings })
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn wrong(&self, detail: &'static str) -> BasisError {
        BasisError::Malformed { version: VERSION, detail, offset: self.at }
    }
    fn take(&mut self, count: usize) -> Result<&'a [u8], BasisError> {
        let end = self.at.checked_add(count).filter(|&end| end <= self.bytes.len());
        let end = end.ok_or_else(|| self.wrong("the file ends early"))?;
        let slice = &self.bytes[self.at..end];
        self.at = end;
        Ok(slice)
    }
    fn array<const N: usize>(&mut self) -> Result<[u8; N], BasisError> {
        Ok(self.take(N)?.try_into().expect("take returns what was asked"))
    }
    fn size(&mut self) -> Result<usize, BasisError> {
        let size = u64::from_le_bytes(self.array()?);
        if size > LARGEST {
            return Err(self.wrong("a size beyond any model"));
        }
        Ok(usize::try_from(size).expect("below 2^20"))
    }
    fn floats(&mut self, count: usize) -> Result<Vec<f64>, BasisError> {
        let bytes = self.take(count.checked_mul(8).ok_or_else(|| self.wrong("a size beyond any model"))?)?;
        let values: Vec<f64> =
            bytes.chunks_exact(8).map(|c| f64::from_le_bytes(c.try_into().expect("chunks of 8"))).collect();
        if values.iter().any(|value| !value.is_finite()) {
            return Err(self.wrong("a number that is not finite"));
        }
        Ok(values)
    }
    fn mode_set(&mut self) -> Result<ModeSet, BasisError> {
        let (rows, columns) = (self.size()?, self.size()?);
        let full_limit = self.floats(1)?[0];
        let omega_squared = self.floats(columns)?;
        let shapes = Matrix::from_vec(rows, columns, self.floats(rows * columns)?);
        Ok(ModeSet { omega_squared, shapes, full_limit })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn basis() -> Basis {
        let set = |n: usize| ModeSet {
            omega_squared: (0..n).map(|i| i as f64).collect(),
            shapes: Matrix::from_fn(4, n, |i, j| (i * 10 + j) as f64),
            full_limit: 99.0,
        };
        Basis { key: [7; 32], lateral: set(3), torsion: set(1), rings: vec![set(2)] }
    }

    #[test]
    fn bytes_go_there_and_back() {
        assert_eq!(Basis::from_bytes(&basis().to_bytes()), Ok(basis()));
    }

    proptest! {
        #[test]
        fn damaged_bytes_are_an_error_never_a_panic(cut in 0usize..400, at in 0usize..400, flip in 1u8..=255) {
            let mut bytes = basis().to_bytes();
            let at = at % bytes.len();
            bytes[at] ^= flip;
            bytes.truncate(bytes.len() - cut % bytes.len());
            let _ = Basis::from_bytes(&bytes);
        }
    }
}
