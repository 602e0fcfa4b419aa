// What stands on the ground, as it is drawn: shared vertices, placed by instances.
#ifndef PLANT_GLSL
#define PLANT_GLSL

#include "lib/quaternion.glsl"

struct Vertex {
    vec3 position;
    uint normal;     // octahedral, two signed normalised 16-bit numbers
    uint openness;   // two 16-bit shares: of the sky and of the ground that the plant's own leaves leave to see
    uint material;   // index into all materials of the picture
};

struct Instance {
    vec3 position;   // of the model's origin
    float scale;
    vec4 rotation;   // unit quaternion
    uint random;
};

vec3 placed(Instance instance, vec3 position) {
    return instance.position + instance.scale * rotate(instance.rotation, position);
}

#endif
