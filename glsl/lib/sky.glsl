// Radiance of the sky, linear Rec.709, cd/m².
#ifndef SKY_GLSL
#define SKY_GLSL

// What the sky is; an includer that knows it before says so.
#ifndef SKY_KIND
#define SKY_KIND frame.sky
#endif

// Texels of a picture of the whole sky, row by row from straight up; columns go clockwise.
layout(binding = 30, scalar) readonly buffer Panorama { vec3 panorama_[]; };

// asin on 0…1 to 32-bit accuracy: drivers' own may be off by 1.6e-4 (after Cephes's asinf, Moshier 1984).
float accurate_asin(float x) {
    bool upper = x > 0.5;
    float z = upper ? 0.5 * (1.0 - x) : x * x;
    float y = upper ? sqrt(z) : x;
    float series = ((((4.2163199048e-2 * z + 2.4181311049e-2) * z + 4.5470025998e-2) * z + 7.4953002686e-2) * z
                    + 1.6666752422e-1) * z * y + y;
    return upper ? 0.5 * PI - 2.0 * series : series;
}

// Cosine and sine of an angle in turns, to 32-bit accuracy for the same reason (after Cephes's sinf and cosf).
vec2 accurate_cos_sin(float turns) {
    float quarters = round(4.0 * turns);
    float x = (4.0 * turns - quarters) * (0.5 * PI);
    float z = x * x;
    float s = ((-1.9515295891e-4 * z + 8.3321608736e-3) * z - 1.6666654611e-1) * z * x + x;
    float c = ((2.443315711809948e-5 * z - 1.388731625493765e-3) * z + 4.166664568298827e-2) * z * z - 0.5 * z + 1.0;
    int quarter = int(quarters) & 3;
    vec2 turned = (quarter & 1) == 0 ? vec2(c, s) : vec2(-s, c);
    return quarter < 2 ? turned : -turned;
}

vec3 rec709_from_xyz(vec3 xyz) {
    return vec3(dot(vec3(3.2404542, -1.5371385, -0.4985314), xyz), dot(vec3(-0.9692660, 1.8760108, 0.0415560), xyz),
                dot(vec3(0.0556434, -0.2040259, 1.0572252), xyz));
}

// Perez's distribution of Y, x and y (Preetham, Shirley & Smits 1999). The angle to the sun comes from the chord,
// since acos of a 32-bit cosine is too coarse near the sun.
vec3 preetham(vec3 view) {
    float gamma = 2.0 * accurate_asin(min(0.5 * distance(view, frame.perez_sun), 1.0));
    float cos_gamma = dot(view, frame.perez_sun);
    vec3 gradient = 1.0 + frame.perez_a * exp(frame.perez_b / max(view.y, 0.001));
    vec3 glow = 1.0 + frame.perez_c * exp(frame.perez_d * gamma) + frame.perez_e * cos_gamma * cos_gamma;
    vec3 yxy = frame.perez_zenith * gradient * glow;
    float scale = yxy.x / yxy.z;
    return rec709_from_xyz(vec3(yxy.y * scale, yxy.x, (1.0 - yxy.y - yxy.z) * scale));
}

// Hosek & Wilkie 2012, equation 8.
vec3 hosek_wilkie(vec3 view) {
    float gamma = 2.0 * accurate_asin(min(0.5 * distance(view, frame.perez_sun), 1.0));
    float cos_gamma = dot(view, frame.perez_sun);
    float ray = cos_gamma * cos_gamma;
    vec3 h = frame.hosek_wilkie[8];
    vec3 haze = (1.0 + ray) / pow(max(1.0 + h * h - 2.0 * h * cos_gamma, 1e-6), vec3(1.5));
    float cos_theta = max(view.y, 0.0);
    vec3 gradient = 1.0 + frame.hosek_wilkie[0] * exp(frame.hosek_wilkie[1] / (cos_theta + 0.01));
    vec3 glow = frame.hosek_wilkie[2] + frame.hosek_wilkie[3] * exp(frame.hosek_wilkie[4] * gamma)
              + frame.hosek_wilkie[5] * ray + frame.hosek_wilkie[6] * haze + frame.hosek_wilkie[7] * sqrt(cos_theta);
    return frame.hosek_wilkie_radiance * gradient * glow;
}

// Angle from straight up, as a share of π.
float from_zenith(vec3 view) {
    float rise = accurate_asin(min(abs(view.y), 1.0)) / PI;
    return 0.5 - (view.y < 0.0 ? -rise : rise);
}

vec3 sky_texel(ivec2 at) {
    ivec2 size = frame.sky_map_size;
    int column = at.x < 0 ? at.x + size.x : at.x >= size.x ? at.x - size.x : at.x;
    return panorama_[clamp(at.y, 0, size.y - 1) * size.x + column];
}

// Bilinear between the middles of texels.
vec3 pictured(vec3 view) {
    float turn = fract(atan(view.x, -view.z) / (2.0 * PI) - frame.sky_map_turn);
    vec2 at = vec2(turn, from_zenith(view)) * vec2(frame.sky_map_size) - 0.5;
    ivec2 first = ivec2(floor(at));
    vec2 t = at - vec2(first);
    return mix(mix(sky_texel(first), sky_texel(first + ivec2(1, 0)), t.x),
               mix(sky_texel(first + ivec2(0, 1)), sky_texel(first + ivec2(1, 1)), t.x), t.y);
}

// From the unit vector `view`; clear skies are below the horizon as at it.
vec3 sky_radiance(vec3 view) {
    if (SKY_KIND == SKY_NONE) return vec3(0.0);
    if (SKY_KIND == SKY_CONSTANT) return frame.sky_constant;
    if (SKY_KIND == SKY_MAP) return pictured(view);
    if (view.y < 0.0) view = normalize(vec3(view.x, 1e-3, view.z));
    return max(SKY_KIND == SKY_PREETHAM ? preetham(view) : hosek_wilkie(view), 0.0);
}

// The disc, darker towards its limb (u = 0.6: Cox 2000, Allen's Astrophysical Quantities).
vec3 sun_disc_radiance(vec3 view) {
    float offset = distance(view, frame.sun_direction) / frame.sun_radius;
    if (offset >= 1.0) return vec3(0.0);
    float limb = 1.0 - 0.6 * (1.0 - sqrt(1.0 - offset * offset));
    float solid_angle = PI * frame.sun_radius * frame.sun_radius;
    return frame.sun_irradiance / solid_angle * limb / 0.8;
}

// What a plane with normal `n` receives from the sky, lux (Ramamoorthi & Hanrahan 2001): the renderer has projected
// the dome and weighted it with the cosine.
vec3 sky_irradiance(vec3 n) {
    vec3 sum = frame.sky_irradiance[0] + frame.sky_irradiance[1] * n.z + frame.sky_irradiance[2] * n.y
             + frame.sky_irradiance[3] * n.x + frame.sky_irradiance[4] * (n.x * n.z)
             + frame.sky_irradiance[5] * (n.z * n.y) + frame.sky_irradiance[6] * (3.0 * n.y * n.y - 1.0)
             + frame.sky_irradiance[7] * (n.x * n.y) + frame.sky_irradiance[8] * (n.x * n.x - n.z * n.z);
    return max(sum, 0.0);
}

#endif
