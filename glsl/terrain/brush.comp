#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// What a hand does to the land at a place: raises or lowers the ground that changes are counted from, pours water, or sets the mask.

#include "lib/grid.glsl"

layout(local_size_x = 128, local_size_y = 1) in;
// RAISE, RAIN, MASK.
layout(constant_id = 0) const uint KIND = 0;
layout(binding = 0, r32f) uniform image2D height;
layout(binding = 1, r32f) uniform image2D start;
layout(binding = 2, r32f) uniform readonly image2D change; // coral, where it grows
layout(binding = 3, rgba32f) uniform image2D water;
layout(binding = 4, rgba32f) uniform image2D controls;
layout(push_constant, scalar) uniform Push {
    ivec2 first;     // cell of the first invocation
    vec2 middle;     // of the brush, in cells
    float radius;    // in cells
    float strength;
    float sea_level; // of rivers: below it water does not stay
    uint coral;      // whether it grows
} push;

const uint RAISE = 0u;
const uint RAIN = 1u;
const uint MASK = 2u;

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy) + push.first;
    if (outside(cell, imageSize(height))) return;

    vec2 away = (vec2(cell) - push.middle) / push.radius;
    float rest = 1.0 - dot(away, away);
    if (rest <= 0.0) return;
    // 1 in the middle, level there and at the rim; over the disc it is a third on average.
    float share = rest * rest;
    if (KIND == RAISE) {
        float before = imageLoad(start, cell).x;
        precise float ground = before + push.strength * share;
        precise float raised = ground + imageLoad(change, cell).x;
        // Rivers ran on what coral grows on. The sea is as deep as ground lies below it: what comes out of it is dry.
        float bed = push.coral != 0u ? before : imageLoad(height, cell).x;
        if (bed < push.sea_level && !outside(cell, imageSize(water))) {
            vec4 wet = imageLoad(water, cell);
            wet.x = max(0.0, push.sea_level - (bed + push.strength * share));
            imageStore(water, cell, wet);
        }
        imageStore(start, cell, vec4(ground));
        imageStore(height, cell, vec4(raised));
    } else if (KIND == RAIN) {
        vec4 wet = imageLoad(water, cell);
        if (imageLoad(height, cell).x >= push.sea_level) wet.x = max(0.0, wet.x + push.strength * share);
        imageStore(water, cell, wet);
    } else {
        // Whole over the middle half of its width.
        vec4 control = imageLoad(controls, cell);
        control.z = mix(control.z, push.strength, min(1.0, 16.0 / 9.0 * share));
        imageStore(controls, cell, control);
    }
}
