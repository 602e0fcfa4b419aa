#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Sea-bed smoothing: the mean of four neighbours below sea level (Korošec & Lebar Bajec (23)).

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) uniform readonly image2D src;
layout(binding = 1, r32f) uniform writeonly image2D dst;
layout(push_constant, scalar) uniform Push { float sea_level; } push;

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 n = imageSize(src);
    if (any(greaterThanEqual(p, n))) return;
    float h = imageLoad(src, p).r;
    bool rim = any(equal(p, ivec2(0))) || any(equal(p, n - 1));
    if (!rim && h < push.sea_level) {
        float l = imageLoad(src, p - ivec2(1, 0)).r, r = imageLoad(src, p + ivec2(1, 0)).r;
        float t = imageLoad(src, p - ivec2(0, 1)).r, b = imageLoad(src, p + ivec2(0, 1)).r;
        h = 0.25 * ((l + r) + (t + b));
    }
    imageStore(dst, p, vec4(h));
}
