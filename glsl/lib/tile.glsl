// The part of the picture that is being drawn.
#ifndef TILE_GLSL
#define TILE_GLSL

layout(push_constant, scalar) uniform Push {
    vec2 scale;     // of the whole picture's clip coordinates
    vec2 offset;
} push;

// Reversed depth: near / distance, 0 at infinity.
vec4 tile_clip(vec3 point) {
    vec3 from_eye = point - frame.eye;
    float depth = dot(frame.forward, from_eye);
    vec2 whole = vec2(dot(frame.right, from_eye), dot(frame.up, from_eye)) / frame.tangent;
    return vec4(whole * push.scale + push.offset * depth, frame.near, depth);
}

#endif
