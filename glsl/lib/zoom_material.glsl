// What the ground of the zoom is made of: by its slope, by how high it lies among what is around, and by its level, so that every scale has
// a character.
#ifndef ZOOM_MATERIAL_GLSL
#define ZOOM_MATERIAL_GLSL

// Reflectances of a landscape: of its hollows, of level ground, of slopes and of summits.
struct Character {
    vec3 hollow;
    vec3 level;
    vec3 slope;
    vec3 summit;
};

const uint CHARACTERS = 5u;
const uint LEVELS_A_CHARACTER = 7u;

const Character characters[CHARACTERS] = Character[](
    // Meadows below snow.
    Character(vec3(0.050, 0.075, 0.022), vec3(0.115, 0.140, 0.045), vec3(0.180, 0.160, 0.140), vec3(0.72, 0.74, 0.78)),
    // Red desert.
    Character(vec3(0.150, 0.060, 0.030), vec3(0.400, 0.200, 0.095), vec3(0.270, 0.105, 0.055), vec3(0.54, 0.36, 0.22)),
    // Basalt with lichen.
    Character(vec3(0.030, 0.032, 0.036), vec3(0.085, 0.082, 0.080), vec3(0.055, 0.053, 0.055), vec3(0.29, 0.28, 0.16)),
    // Chalk and turquoise.
    Character(vec3(0.060, 0.190, 0.190), vec3(0.420, 0.430, 0.390), vec3(0.300, 0.300, 0.280), vec3(0.74, 0.72, 0.66)),
    // Heather on granite.
    Character(vec3(0.060, 0.058, 0.032), vec3(0.165, 0.100, 0.098), vec3(0.230, 0.190, 0.170), vec3(0.42, 0.38, 0.37))
);

// The reflectance at a vertex of a level. `slope` is the tangent of its angle; `relief` is how high it lies, −1…1.
vec3 reflectance(float slope, float relief, uint level) {
    uint position = level % (CHARACTERS * LEVELS_A_CHARACTER);
    uint first = position / LEVELS_A_CHARACTER;
    float part = float(position % LEVELS_A_CHARACTER) / float(LEVELS_A_CHARACTER);
    Character from = characters[first];
    Character to = characters[(first + 1u) % CHARACTERS];
    float next = smoothstep(0.4, 1.0, part);
    vec3 ground = mix(mix(from.hollow, to.hollow, next), mix(from.level, to.level, next), smoothstep(-0.40, 0.05, relief));
    ground = mix(ground, mix(from.summit, to.summit, next), smoothstep(0.12, 0.42, relief + 0.12 - 0.12 * slope));
    return mix(ground, mix(from.slope, to.slope, next), smoothstep(0.55, 1.25, slope));
}

#endif
