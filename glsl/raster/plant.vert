#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Places the vertices of one model's instances.

#include "lib/frame.glsl"
#include "lib/octahedron.glsl"
#include "lib/plant.glsl"
#include "lib/tile.glsl"

layout(binding = 1, scalar) readonly buffer Instances { Instance instances[]; };
layout(binding = 2, scalar) readonly buffer Vertices { Vertex vertices[]; };

layout(location = 0) out vec3 point;
layout(location = 1) out vec3 normal;
layout(location = 2) out vec2 openness;  // shares of sky and ground
layout(location = 3) flat out uvec2 identity;  // material; random number of the instance

void main() {
    Vertex vertex = vertices[gl_VertexIndex];
    Instance instance = instances[gl_InstanceIndex];
    point = placed(instance, vertex.position);
    normal = rotate(instance.rotation, unpack_direction(vertex.normal));
    openness = unpackUnorm2x16(vertex.openness);
    identity = uvec2(vertex.material, instance.random);
    gl_Position = tile_clip(point);
}
