//! Counter-based random numbers: every number is a pure function of (seed, purpose, pass, index, dimension), so the
//! order of work never matters. Philox4x32 with ten rounds `[Salmon11]`.

/// What a stream is drawn for; different purposes never share numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Purpose {
    /// Paths from the camera; the index is pixel · samples per pixel + sample.
    Camera = 1,
    /// Choices along a photon's path; the index is the photon.
    Photon = 2,
    /// Shifts of the emission lattices; the index is the light.
    Lattice = 3,
    /// Rays of the cross-check between backends.
    Crosscheck = 4,
    /// Light paths of the light tracer.
    LightPath = 5,
    /// Numbers that tests draw.
    Test = 6,
    /// Pilots that learn where a light's photons are worth sending; the index is the pilot.
    Guide = 7,
    /// Places on photons' ways through media; the index is the way.
    Collision = 8,
}

/// The numbers of one path.
#[derive(Clone, Debug)]
pub struct Stream {
    key: [u32; 2],
    counter: [u32; 4],
    block: [u32; 4],
    used: usize,
}

impl Stream {
    pub fn new(seed: u64, purpose: Purpose, pass: u32, index: u64) -> Stream {
        // The purpose is mixed into the key; pass, index and block number make the counter.
        let key =
            [seed as u32 ^ (purpose as u32).wrapping_mul(0x9E37_79B9), (seed >> 32) as u32 ^ pass.rotate_left(16)];
        Stream { key, counter: [0, pass, index as u32, (index >> 32) as u32], block: [0; 4], used: 4 }
    }

    fn next_u32(&mut self) -> u32 {
        if self.used == 4 {
            self.block = philox4x32(self.counter, self.key);
            self.counter[0] = self.counter[0].wrapping_add(1);
            self.used = 0;
        }
        self.used += 1;
        self.block[self.used - 1]
    }

    /// Uniform in [0, 1) with 53 random bits.
    pub fn uniform(&mut self) -> f64 {
        let high = u64::from(self.next_u32());
        let low = u64::from(self.next_u32());
        ((high << 32 | low) >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Two independent uniforms.
    pub fn uniform2(&mut self) -> [f64; 2] {
        [self.uniform(), self.uniform()]
    }
}

fn philox4x32(mut c: [u32; 4], mut k: [u32; 2]) -> [u32; 4] {
    for _ in 0..10 {
        let p0 = 0xD251_1F53u64 * u64::from(c[0]);
        let p1 = 0xCD9E_8D57u64 * u64::from(c[2]);
        c = [(p1 >> 32) as u32 ^ c[1] ^ k[0], p1 as u32, (p0 >> 32) as u32 ^ c[3] ^ k[1], p0 as u32];
        k = [k[0].wrapping_add(0x9E37_79B9), k[1].wrapping_add(0xBB67_AE85)];
    }
    c
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known answers published with the algorithm `[Salmon11]`.
    #[test]
    fn philox_known_answers() {
        assert_eq!(philox4x32([0; 4], [0; 2]), [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]);
        assert_eq!(philox4x32([u32::MAX; 4], [u32::MAX; 2]), [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]);
    }

    #[test]
    fn streams_differ_in_every_part_of_their_key() {
        let first = |seed, purpose, pass, index| Stream::new(seed, purpose, pass, index).uniform();
        let a = first(1, Purpose::Photon, 2, 3);
        assert_eq!(a, first(1, Purpose::Photon, 2, 3));
        for b in [
            first(2, Purpose::Photon, 2, 3),
            first(1, Purpose::Camera, 2, 3),
            first(1, Purpose::Photon, 3, 3),
            first(1, Purpose::Photon, 2, 4),
        ] {
            assert_ne!(a, b);
        }
    }
}
