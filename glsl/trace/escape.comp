#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Paths that meet nothing more: they take the light of the sky and the sun.

#include "lib/frame.glsl"
#include "lib/turn.glsl"

layout(local_size_x = GROUP) in;

#include "lib/texture.glsl"
#include "lib/clouds.glsl"

// Whatever the path sees beyond all surfaces. A light that the last place looked for counts by how much better the path finds
// it (Veach & Guibas 1995, the balance heuristic).
vec3 beyond(Path path) {
    vec3 direction = path.direction;
    bool looked = path.density > 0.0;
    vec3 light = sky_radiance(direction);
    if (looked) light *= path.density / (path.density + path.sky_share * dome_density(direction));
    if (has_sun() && in_sun(direction)) {
        float share = looked ? path.density / (path.density + (1.0 - path.sky_share) / sun_solid_angle()) : 1.0;
        light += share * sun_radiance();
    }
    return light;
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= turns[push.work.turn].escaped.paths) return;
    uint index = queue[slot];
    Path path = paths[index];
    if (push.work.turn == 0u) features[index] = Feature(vec3(0.0), vec3(0.0), vec3(0.0), 0.0, 0u);
    if (path.medium == WATER) {
        // Beyond the land's skirt the sea has no bottom: only its own light comes from there.
        Hit hit = hits[index];
        hit.range = ENDLESS;
        arrive(index, path, hit);
        return;
    }
    vec3 light = beyond(path);
    // Clouds are a backdrop: the eye sees them, and they give no light. Other renderers don't have them.
    if (push.work.turn == 0u && push.work.plain == 0u) light = with_clouds(light, path.direction, 1e9);
    paths[index].radiance = path.radiance + path.throughput * light;
}
