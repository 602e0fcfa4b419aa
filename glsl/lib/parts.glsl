// What samples see, so that each kind is shaded by a program of its own: a device that runs many samples in step does for all of them what
// one of them needs. `lib/frame.glsl` stands before. Twin of `raster/live/parts.rs`.
#ifndef PARTS_GLSL
#define PARTS_GLSL

const uint CLEAR = 0u;    // sky without clouds
const uint CLOUDY = 1u;   // sky that clouds may cover
const uint SEA = 2u;
const uint GROUND = 3u;
const uint PLANT = 4u;

// Side of the square tiles that samples are sorted in: a workgroup.
const int TILE_SIDE = 8;

// What lies along `view`, and how far away it is, where the nearest ground is at `first_range`: negative is the range of a plant.
uint part_of(vec3 view, float first_range, out float path) {
    path = abs(first_range);
    float sea = range_of_sea(view);
    if (sea > 0.0 && (path == 0.0 || sea < path)) {
        path = sea;
        return SEA;
    }
    if (first_range < 0.0) return PLANT;
    if (path > 0.0) return GROUND;
    return may_have_clouds(view) ? CLOUDY : CLEAR;
}

#endif
