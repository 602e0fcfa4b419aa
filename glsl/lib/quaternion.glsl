// Rotations as unit quaternions (x, y, z, w).
#ifndef QUATERNION_GLSL
#define QUATERNION_GLSL

vec3 rotate(vec4 rotation, vec3 v) {
    return v + 2.0 * cross(rotation.xyz, cross(rotation.xyz, v) + rotation.w * v);
}

vec4 conjugate(vec4 rotation) {
    return vec4(-rotation.xyz, rotation.w);
}

#endif
