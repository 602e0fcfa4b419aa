// Where plants hide the sun, softly: the farther away what hides it, the softer (Fernando 2005, "Percentage-Closer Soft
// Shadows"). The includer declares `casts` and the r32f image `cast_maps`, which holds how far towards the sun lies
// what meets it first.
#ifndef CASTS_GLSL
#define CASTS_GLSL

#include "lib/cast.glsl"

const float GOLDEN_ANGLE = 2.39996323;

// At a texel of a map; beyond its rim as at it.
float cast_along(ivec2 first, int side, vec2 at) {
    return imageLoad(cast_maps, first + clamp(ivec2(floor(at)), ivec2(0), ivec2(side - 1))).x;
}

// Share of the sun's disc that no plant hides from `point`, by that many looks; `elsewhere` beyond all maps. What is
// nearer than `bias` metres hides nothing: a surface must not shade itself. `turn` differs from sample to sample.
float cast_visibility(vec3 point, float bias, int looks, float turn, float elsewhere) {
    float depth = dot(frame.forward, point - frame.eye);
    int index = 0;
    while (index < 4 && depth >= casts[index].depth) ++index;
    if (index == 4) return elsewhere;
    Cast cast_ = casts[index];
    vec3 place = cast_place(cast_, point);
    int side = imageSize(cast_maps).x / CAST_COLUMNS;
    ivec2 first = ivec2(index % CAST_COLUMNS, index / CAST_COLUMNS) * side;
    float texels = float(side);
    float texel = 2.0 * cast_.half_size / texels;
    vec2 middle = (vec2(place.x, -place.y) * 0.5 + 0.5) * texels;
    float along = place.z + bias + texel;

    // How far away is what hides the sun?
    float widest = clamp(0.12 / texel, 1.5, 16.0);
    float sum = 0.0;
    float hidden = 0.0;
    for (int look = 0; look < looks; ++look) {
        float angle = float(look) * GOLDEN_ANGLE + turn;
        vec2 offset = widest * sqrt((float(look) + 0.5) / float(looks)) * vec2(cos(angle), sin(angle));
        float found = cast_along(first, side, middle + offset);
        if (found > along) {
            sum += found - place.z;
            hidden += 1.0;
        }
    }
    if (hidden == 0.0) return 1.0;
    float radius = clamp(sum / hidden * tan(frame.sun_radius) / texel, 0.7, widest);
    float seen = 0.0;
    for (int look = 0; look < looks; ++look) {
        float angle = float(look) * GOLDEN_ANGLE + turn;
        vec2 offset = radius * sqrt((float(look) + 0.5) / float(looks)) * vec2(cos(angle), sin(angle));
        seen += cast_along(first, side, middle + offset) > along ? 0.0 : 1.0;
    }
    seen /= float(looks);
    // The last map fades into what is known beyond.
    return index == 3 ? mix(seen, elsewhere, smoothstep(0.8, 1.0, depth / cast_.depth)) : seen;
}

// Evenly spread over a turn in every small neighbourhood of the picture (Jimenez 2014, "Next Generation Post Processing in
// Call of Duty: Advanced Warfare").
float cast_turn(ivec2 sample_) {
    return 2.0 * PI * fract(52.9829189 * fract(dot(vec2(sample_), vec2(0.06711056, 0.00583715))));
}

#endif
