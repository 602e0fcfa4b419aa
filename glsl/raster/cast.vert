#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Places the vertices of one model's instances in a shadow map.

#include "lib/frame.glsl"
#include "lib/plant.glsl"
#include "lib/cast.glsl"

layout(binding = 1, scalar) readonly buffer Instances { Instance instances[]; };
layout(binding = 2, scalar) readonly buffer Vertices { Vertex vertices[]; };
layout(binding = 3, scalar) readonly buffer Casts { Cast casts[]; };

layout(push_constant, scalar) uniform Push {
    int map;
} push;

layout(location = 0) out vec3 place;   // in the map, and along

void main() {
    Cast cast_ = casts[push.map];
    place = cast_place(cast_, placed(instances[gl_InstanceIndex], vertices[gl_VertexIndex].position));
    // Its own square of the image, from the upper left.
    vec2 square = vec2(push.map % CAST_COLUMNS, CAST_COLUMNS - 1 - push.map / CAST_COLUMNS);
    vec2 at = (place.xy + 1.0 + 2.0 * square) / float(CAST_COLUMNS) - 1.0;
    // Reversed depth: what meets the sun first has the greatest.
    gl_Position = vec4(at, 0.5 + 0.5 * place.z / cast_.reach, 1.0);
}
