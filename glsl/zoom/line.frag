#version 460

layout(location = 0) in vec3 place;
layout(location = 1) flat in vec3 colour;

// Radiance, cd/m², and the distance.
layout(location = 0) out vec4 radiance;

void main() {
    radiance = vec4(colour, length(place));
}
