//! Integer hashing, from which every random number of a world comes, and how hashes are written.

/// Derives the seed of one consumer from the world's seed and the consumer's key path, for example
/// `terrain.layers.2`: adding a consumer never changes another.
///
/// FNV-1a over the path (Fowler, Noll & Vo 1991), started from the world's seed and finished by
/// [`mix`].
pub fn derive_seed(seed: u32, key_path: &str) -> u32 {
    let start = mix(seed ^ 0x811c_9dc5);
    mix(key_path.bytes().fold(start, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193)))
}

/// A bijection of the 32-bit integers that scatters neighbouring inputs: the PCG-RXS-M-XS step
/// (O'Neill 2014; recommended for GPUs by Jarzynski & Olano 2020). `glsl/lib/hash.glsl` has its twin.
pub fn mix(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Bytes as lower-case hexadecimal digits, the way digests are written.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_has_two_digits() {
        assert_eq!(hexadecimal(&[0, 10, 0xf5]), "000af5");
        assert_eq!(hexadecimal(&[]), "");
    }
}
