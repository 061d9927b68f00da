//! Tags, and keys that are derived from keys. Cipher and mode are the crates `aes` and `cmac`.

use super::{Key, TAG_LEN, cipher::Cipher};
use cmac::{
    Cmac, CmacCore, Mac as _,
    digest::{FixedOutput, InnerInit, Update, core_api::CoreWrapper},
};

/// AES-128-CMAC under one key, its round keys worked out.
#[derive(Clone)]
pub(super) struct Mac(Cmac<Cipher>);

impl Mac {
    pub(super) fn new(key: &Key) -> Self {
        Self(CoreWrapper::from_core(CmacCore::inner_init(Cipher::new(key.bytes()))))
    }

    /// The first eight bytes of the code of `message`: SP 800-38B, 6.2.
    pub(super) fn tag(&self, message: &[u8]) -> [u8; TAG_LEN] {
        let code = self.code(&[message]);
        core::array::from_fn(|at| code[at])
    }

    /// Whether `tag` is that of `message`, found out in a time that does not depend on where they differ.
    pub(super) fn fits(&self, message: &[u8], tag: &[u8; TAG_LEN]) -> bool {
        let mut mac = self.0.clone();
        Update::update(&mut mac, message);
        mac.verify_truncated_left(tag).is_ok()
    }

    fn code(&self, parts: &[&[u8]]) -> [u8; 16] {
        let mut mac = self.0.clone();
        for part in parts {
            Update::update(&mut mac, part);
        }
        mac.finalize_fixed().into()
    }
}

/// A key derived from `key`: NIST SP 800-108r1, 4.1, counter mode with CMAC, of which one block is all that is needed.
///
/// The fixed input is `label`, a zero byte, `context`, and the length of what is derived, 128 bits.
pub(super) fn derive(key: &Key, label: &[u8], context: &[&[u8]]) -> Key {
    const COUNTER: [u8; 4] = 1_u32.to_be_bytes();
    const BITS: [u8; 4] = 128_u32.to_be_bytes();
    let mut mac = Mac::new(key).0;
    Update::update(&mut mac, &COUNTER);
    Update::update(&mut mac, label);
    Update::update(&mut mac, &[0]);
    for part in context {
        Update::update(&mut mac, part);
    }
    Update::update(&mut mac, &BITS);
    Key::new(mac.finalize_fixed().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// RFC 4493, 4: the key, and the first bytes of all messages.
    const KEY: &str = "2b7e151628aed2a6abf7158809cf4f3c";
    const MESSAGE: [u8; 64] = [
        0x6b, 0xc1, 0xbe, 0xe2, 0x2e, 0x40, 0x9f, 0x96, 0xe9, 0x3d, 0x7e, 0x11, 0x73, 0x93, 0x17, 0x2a, 0xae,
        0x2d, 0x8a, 0x57, 0x1e, 0x03, 0xac, 0x9c, 0x9e, 0xb7, 0x6f, 0xac, 0x45, 0xaf, 0x8e, 0x51, 0x30, 0xc8,
        0x1c, 0x46, 0xa3, 0x5c, 0xe4, 0x11, 0xe5, 0xfb, 0xc1, 0x19, 0x1a, 0x0a, 0x52, 0xef, 0xf6, 0x9f, 0x24,
        0x45, 0xdf, 0x4f, 0x9b, 0x17, 0xad, 0x2b, 0x41, 0x7b, 0xe6, 0x6c, 0x37, 0x10,
    ];
    const CODES: [(usize, &str); 4] = [
        (0, "bb1d6929e95937287fa37d129b756746"),
        (16, "070a16b46b4d4144f79bdd9dd04a287c"),
        (40, "dfa66747de9ae63030ca32611497c827"),
        (64, "51f0bebf7e3b9d92fc49741779363cfe"),
    ];

    #[test]
    fn codes_are_those_of_rfc_4493() {
        let mac = Mac::new(&Key::from_hex(KEY).unwrap());
        for (length, expected) in CODES {
            let expected = Key::from_hex(expected).unwrap();
            let message = &MESSAGE[..length];
            assert_eq!(mac.code(&[message]), *expected.bytes(), "{length} bytes");
            let tag = *expected.bytes().first_chunk().unwrap();
            assert_eq!(mac.tag(message), tag);
            assert!(mac.fits(message, &tag));
        }
    }

    #[test]
    fn a_tag_with_any_bit_changed_does_not_fit() {
        let mac = Mac::new(&Key::from_hex(KEY).unwrap());
        let tag = mac.tag(&MESSAGE);
        for bit in 0..8 * TAG_LEN {
            let mut changed = tag;
            changed[bit / 8] ^= 1 << (bit % 8);
            assert!(!mac.fits(&MESSAGE, &changed), "bit {bit}");
        }
    }

    /// SP 800-108r1 leaves label, context and length to the application: the definition, written out as one message.
    #[test]
    fn a_derived_key_is_the_code_of_counter_label_context_and_length() {
        let key = Key::from_hex(KEY).unwrap();
        let message = *b"\0\0\0\x01label\0\x01\x02\x03\0\0\0\x80";
        let derived = derive(&key, b"label", &[&[1, 2], &[3]]);
        assert_eq!(*derived.bytes(), Mac::new(&key).code(&[&message]));
        assert_ne!(derived.bytes(), derive(&key, b"label", &[&[1, 2], &[4]]).bytes());
    }
}
