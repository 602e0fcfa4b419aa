#version 460
#extension GL_EXT_scalar_block_layout : require

// Triangles of the user interface.

struct PanelVertex {
    vec2 position;      // points, from the upper left corner of the window
    vec2 uv;
    uint colour;        // sRGB and alpha, 8 bits each, red lowest; multiplied by alpha
};

layout(binding = 0, scalar) readonly buffer Vertices { PanelVertex vertices[]; };

layout(push_constant, scalar) uniform Push {
    vec2 size;          // of the window, points
} push;

layout(location = 0) out vec2 uv;
layout(location = 1) out vec4 colour;

void main() {
    PanelVertex vertex = vertices[gl_VertexIndex];
    uv = vertex.uv;
    colour = unpackUnorm4x8(vertex.colour);
    vec2 place = vertex.position / push.size;
    gl_Position = vec4(2.0 * place.x - 1.0, 1.0 - 2.0 * place.y, 0.5, 1.0);
}
