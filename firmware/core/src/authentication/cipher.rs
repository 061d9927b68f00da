//! AES-128 for CMAC, which asks of it in every code what it makes of a block of zeros. That is the same for a key, and is kept:
//! a third of the time that the tag of a short frame takes.

use aes::{
    Aes128Enc, Block,
    cipher::{
        BlockBackend, BlockCipher, BlockClosure, BlockEncrypt, BlockSizeUser, KeyInit, ParBlocksSizeUser,
        consts::{U1, U16},
        inout::InOut,
    },
};

/// The cipher under one key.
#[derive(Clone)]
pub(super) struct Cipher {
    aes: Aes128Enc,
    of_zero: Block,
}

impl Cipher {
    pub(super) fn new(key: &[u8; 16]) -> Self {
        let aes = Aes128Enc::new(key.into());
        let mut of_zero = Block::default();
        aes.encrypt_block(&mut of_zero);
        Self { aes, of_zero }
    }
}

impl BlockSizeUser for Cipher {
    type BlockSize = U16;
}

impl BlockCipher for Cipher {}

impl BlockEncrypt for Cipher {
    fn encrypt_with_backend(&self, f: impl BlockClosure<BlockSize = U16>) {
        f.call(&mut Backend(self));
    }
}

/// One block at a time, as CMAC has them.
struct Backend<'c>(&'c Cipher);

impl BlockSizeUser for Backend<'_> {
    type BlockSize = U16;
}

impl ParBlocksSizeUser for Backend<'_> {
    type ParBlocksSize = U1;
}

impl BlockBackend for Backend<'_> {
    // Once in flash: it is a thousand instructions long.
    #[inline(never)]
    fn proc_block(&mut self, mut block: InOut<'_, '_, Block>) {
        // All bytes are looked at. That a block is zero tells nothing but that the code is about to end.
        if block.get_in().iter().fold(0, |all, byte| all | byte) == 0 {
            *block.get_out() = self.0.of_zero;
        } else {
            self.0.aes.encrypt_block_inout(block);
        }
    }
}
