#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Lines among the zoom's tiles, as wide everywhere: each is two triangles that face the eye. Devices need not draw lines that are wider than a sample.

#include "lib/frame.glsl"

struct ZoomLine {
    vec3 from;          // from the eye
    vec3 to;
    vec3 colour;        // radiance
};

layout(binding = 1, scalar) readonly buffer Lines { ZoomLine lines[]; };

layout(push_constant, scalar) uniform Push {
    float near;         // distance of the near plane
    float width;        // samples
} push;

layout(location = 0) out vec3 place;
layout(location = 1) flat out vec3 colour;

// The corners of two triangles: at which end, and on which side.
const vec2 corners[6] = vec2[](vec2(0.0, -1.0), vec2(1.0, -1.0), vec2(1.0, 1.0), vec2(0.0, -1.0), vec2(1.0, 1.0), vec2(0.0, 1.0));

// As tiles are seen (zoom/tile.vert).
vec4 seen(vec3 place) {
    return vec4(dot(frame.right, place) / frame.tangent.x, dot(frame.up, place) / frame.tangent.y, push.near, dot(frame.forward, place));
}

void main() {
    ZoomLine line = lines[gl_InstanceIndex];
    vec4 from = seen(line.from);
    vec4 to = seen(line.to);
    colour = line.colour;
    place = line.from;
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
    if (max(from.w, to.w) <= push.near) return;

    // Shares of the way between which it lies before the near plane: what is nearer is nowhere in the picture.
    float rise = to.w - from.w;
    float first = from.w < push.near ? (push.near - from.w) / rise : 0.0;
    float last = to.w < push.near ? (push.near - from.w) / rise : 1.0;
    vec4 start = mix(from, to, first);
    vec4 end = mix(from, to, last);
    vec2 way = (end.xy / end.w - start.xy / start.w) * frame.samples;
    vec2 across = length(way) > 0.0 ? vec2(-way.y, way.x) / length(way) : vec2(1.0, 0.0);

    vec2 corner = corners[gl_VertexIndex];
    gl_Position = mix(start, end, corner.x);
    gl_Position.xy += corner.y * push.width * across / frame.samples * gl_Position.w;
    place = mix(line.from, line.to, mix(first, last, corner.x));
}
