// Triangles as they lie in memory. The includer declares the texel buffer `triangles`.
#ifndef TRIANGLES_GLSL
#define TRIANGLES_GLSL

#include "lib/tree.glsl"

Triangle triangle_at(uint index) {
    int at = 3 * int(index);
    uvec4 first = texelFetch(triangles, at);
    uvec4 second = texelFetch(triangles, at + 1);
    uvec4 third = texelFetch(triangles, at + 2);
    vec3 a = uintBitsToFloat(first.xyz);
    vec3 b = uintBitsToFloat(uvec3(first.w, second.xy));
    vec3 c = uintBitsToFloat(uvec3(second.zw, third.x));
    return Triangle(a, b, c, uint[3](third.y, third.z, third.w));
}

#endif
