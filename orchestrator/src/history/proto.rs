//! Hand-written protobuf: messages of `double` fields, their descriptor, and parsing of both.
//!
//! A message is `tag, 8 bytes` for each field in order, tag = number << 3 | 1 (fixed64) as a varint; the descriptor is a
//! `FileDescriptorSet` of one file with one message type (descriptor.proto of protobuf, syntax "proto3").

/// Package of the message types.
pub const PACKAGE: &str = "bladeoff";

const FIXED64: u64 = 1;
const LENGTH: u64 = 2;
const TYPE_DOUBLE: u64 = 1;
const LABEL_OPTIONAL: u64 = 1;

fn varint(mut value: u64, out: &mut Vec<u8>) {
    while value >= 0x80 {
        out.push((value & 0x7f) as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

fn bytes_field(number: u64, bytes: &[u8], out: &mut Vec<u8>) {
    varint(number << 3 | LENGTH, out);
    varint(bytes.len() as u64, out);
    out.extend_from_slice(bytes);
}

fn varint_field(number: u64, value: u64, out: &mut Vec<u8>) {
    varint(number << 3, out);
    varint(value, out);
}

/// Descriptor of a message type whose fields, numbered from 1, are doubles.
#[must_use]
pub fn descriptor(message: &str, fields: &[String]) -> Vec<u8> {
    let mut kind = Vec::new();
    bytes_field(1, message.as_bytes(), &mut kind);
    for (at, name) in fields.iter().enumerate() {
        let mut field = Vec::new();
        bytes_field(1, name.as_bytes(), &mut field);
        varint_field(3, at as u64 + 1, &mut field);
        varint_field(4, LABEL_OPTIONAL, &mut field);
        varint_field(5, TYPE_DOUBLE, &mut field);
        // json_name: without it readers turn gap_m into gapM
        bytes_field(10, name.as_bytes(), &mut field);
        bytes_field(2, &field, &mut kind);
    }
    let mut file = Vec::new();
    bytes_field(1, format!("{PACKAGE}/{message}.proto").as_bytes(), &mut file);
    bytes_field(2, PACKAGE.as_bytes(), &mut file);
    bytes_field(4, &kind, &mut file);
    bytes_field(12, b"proto3", &mut file);
    let mut set = Vec::new();
    bytes_field(1, &file, &mut set);
    set
}

/// A message of doubles.
pub fn message(values: &[f64], out: &mut Vec<u8>) {
    for (at, value) in values.iter().enumerate() {
        varint((at as u64 + 1) << 3 | FIXED64, out);
        out.extend_from_slice(&value.to_le_bytes());
    }
}

/// A field of a parsed message.
enum Field<'a> {
    Varint,
    Fixed64(u64),
    Bytes(&'a [u8]),
    Fixed32,
}

/// Splits bytes into fields; `None` if they are not protobuf.
fn fields(mut bytes: &[u8]) -> Option<Vec<(u64, Field<'_>)>> {
    let mut all = Vec::new();
    while !bytes.is_empty() {
        let tag = take_varint(&mut bytes)?;
        let field = match tag & 7 {
            0 => {
                take_varint(&mut bytes)?;
                Field::Varint
            }
            FIXED64 => Field::Fixed64(u64::from_le_bytes(take(&mut bytes, 8)?.try_into().ok()?)),
            LENGTH => {
                let length = usize::try_from(take_varint(&mut bytes)?).ok()?;
                Field::Bytes(take(&mut bytes, length)?)
            }
            5 => {
                take(&mut bytes, 4)?;
                Field::Fixed32
            }
            _ => return None,
        };
        all.push((tag >> 3, field));
    }
    Some(all)
}

fn take<'a>(bytes: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (head, tail) = bytes.split_at_checked(count)?;
    *bytes = tail;
    Some(head)
}

fn take_varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut value = 0u64;
    for shift in (0..64).step_by(7) {
        let byte = take(bytes, 1)?[0];
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Some(value);
        }
    }
    None
}

/// Field names of the first message type of a descriptor, in the order of their numbers 1, 2, ...; `None` if this module did not write
/// the descriptor.
#[must_use]
pub fn field_names(descriptor: &[u8]) -> Option<Vec<String>> {
    let inner = |bytes, number| {
        fields(bytes)?.into_iter().find_map(|(found, field)| match field {
            Field::Bytes(bytes) if found == number => Some(bytes),
            _ => None,
        })
    };
    let kind = inner(inner(descriptor, 1)?, 4)?;
    let mut names = Vec::new();
    for (number, field) in fields(kind)? {
        if let (2, Field::Bytes(field)) = (number, field) {
            names.push(String::from_utf8(inner(field, 1)?.to_vec()).ok()?);
        }
    }
    Some(names)
}

/// Values of a message of `count` doubles; a missing field is zero (proto3). `None` if the bytes are not such a message.
#[must_use]
pub fn values(bytes: &[u8], count: usize) -> Option<Vec<f64>> {
    let mut values = vec![0.0; count];
    for (number, field) in fields(bytes)? {
        if let Field::Fixed64(bits) = field {
            let at = usize::try_from(number.checked_sub(1)?).ok()?;
            *values.get_mut(at)? = f64::from_bits(bits);
        }
    }
    Some(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn messages_and_descriptors_go_there_and_back() {
        let names: Vec<String> = (0..40).map(|k| format!("field{k}_m")).collect();
        assert_eq!(field_names(&descriptor("Contact", &names)), Some(names));
        let sent: Vec<f64> = (0..40).map(|k| f64::from(k) * 0.1 - 1.0).collect();
        let mut bytes = Vec::new();
        message(&sent, &mut bytes);
        assert_eq!(values(&bytes, 40), Some(sent));
        assert_eq!(values(&bytes, 39), None, "a field too many is refused");
    }

    proptest! {
        #[test]
        fn damaged_bytes_are_refused_or_read_never_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = field_names(&bytes);
            let _ = values(&bytes, 3);
        }
    }
}
