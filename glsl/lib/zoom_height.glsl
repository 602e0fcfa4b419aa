// The surface of a zoom in 32-bit words and what it is shaded by, the twin of zoom/height. Additions wrap, shifts of signed numbers keep the sign: the same
// on every device.
#ifndef ZOOM_HEIGHT_GLSL
#define ZOOM_HEIGHT_GLSL

const uint FRACTION_BITS = 8u;

// A bijection of the 32-bit integers with little bias (Wellons 2018: lowbias32). Twin of `mix`.
uint scramble(uint value) {
    value = (value ^ value >> 16) * 0x7feb352du;
    value = (value ^ value >> 15) * 0x846ca68bu;
    return value ^ value >> 16;
}

// A coordinate modulo 2^64, its lower word first.
uvec2 plus(uvec2 coordinate, uint steps) {
    uint carry;
    uint low = uaddCarry(coordinate.x, steps, carry);
    return uvec2(low, coordinate.y + carry);
}

// The random number of a vertex: odd, in ±(2^8 − 1). The key is that of its level.
int noise(uint key, uvec2 x, uvec2 z) {
    uint hash = scramble(key ^ x.x);
    hash = scramble(hash ^ x.y + 0x68bc21ebu);
    hash = scramble(hash ^ z.x);
    hash = scramble(hash ^ z.y + 0x02e5be93u);
    return 2 * int(hash >> 32u - FRACTION_BITS) + 1 - (1 << FRACTION_BITS);
}

// Twice the height of the coarser surface at a vertex of the next level, from the corners 00, 10, 01, 11 (x, z) of the coarse cell
// that begins at or before it.
int twice(bool bilinear, bvec2 odd, bool rises, int a, int b, int c, int d) {
    if (!odd.x && !odd.y) return a + a;
    if (!odd.y) return a + b;
    if (!odd.x) return a + c;
    // Differences, because halves of numbers that have wrapped are wrong.
    if (bilinear) return a + a + (b - a + (c - a) + (d - a) >> 1);
    return rises ? a + d : b + c;
}

// What a vertex of the next level lies between: the ends of the coarse edge or diagonal that it is the middle of, as corners (x, z) of the coarse
// cell that begins at or before it, or twice the vertex that it is.
void ends(uvec2 odd, bool rises, out uvec2 near, out uvec2 far) {
    bool falls = odd == uvec2(1u) && !rises;
    near = falls ? uvec2(1u, 0u) : uvec2(0u);
    far = falls ? uvec2(0u, 1u) : odd;
}

// log2 of the levels in which gradients forget what they have missed of the true slope.
const int MEMORY_BITS = 4;

// A gradient, a step nearer to the true slope: what finer vertices get theirs from.
ivec2 settled(ivec2 gradient, ivec2 slope) {
    return gradient + (slope - gradient + (1 << MEMORY_BITS - 1) >> MEMORY_BITS);
}

#endif
