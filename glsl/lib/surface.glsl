// What the bare ground looks like: four materials, blended by slope, height, shore, rivers and reef (Korošec & Lebar
// Bajec, "Procedural generation of a tropical island and coral reef"), each with a procedural texture.
#ifndef SURFACE_GLSL
#define SURFACE_GLSL

// A place on the ground and what is known of it.
struct Place {
    vec3 point;
    vec2 slope;        // dh/dx, dh/dz
    float wetness;     // 0…1, how lately water ran here
    float reef;        // metres of coral grown
    float openness;    // 0…1, share of the sky that it sees
    float footprint;   // metres that one sample covers
};

struct Ground {
    vec4 weights;      // grass, rock, sand, sea floor; they sum to 1
    vec3 albedo;
    vec3 normal;       // with the texture's relief
};

Ground ground(Place place) {
    vec2 xz = place.point.xz;
    float above = place.point.y - frame.sea_level;
    float steepness = atan(length(place.slope));
    float footprint = place.footprint;

    // Two broad patterns break up every boundary and every colour; two fine ones give relief.
    vec3 broad = mottle(xz, frame.patch_size, 7, 0.6, footprint, 11u);
    vec3 hue = mottle(xz, 0.55 * frame.patch_size, 4, 0.7, footprint, 31u);
    vec3 trees = billows(xz, 0.09 * frame.patch_size, 7, 0.72, footprint, 51u);
    // What only somebody who stands on the ground sees: clumps and litter, tufts and stones, blades and grains.
    vec3 litter = mottle(xz, 2.9, 4, 0.75, footprint, 91u);
    vec3 grain = billows(xz, 0.42, 6, 0.8, footprint, 101u);

    // Weights. The waves' own reach stays sandy on steeper shores; where rivers ran lately rock is bare.
    float beach = 1.0 - smoothstep(0.55, 1.0, above / max(frame.beach_height, 1e-3) - 0.45 * broad.x);
    float holds = max(frame.beach_slope, 1e-3) * mix(2.5, 1.0, smoothstep(0.2, 1.2, above));
    beach *= 1.0 - smoothstep(0.75, 1.25, steepness / holds);
    float submerged = 1.0 - smoothstep(-1.2, -0.1, above);
    float bare = smoothstep(frame.rock_slope.x, frame.rock_slope.y, steepness + 0.10 * broad.x + 0.05 * trees.x);
    float river = smoothstep(0.25, 0.75, place.wetness + 0.15 * broad.x) * smoothstep(0.0, 2.0, above);
    float rock = max(bare, river);
    float sand = max(beach, submerged) * (1.0 - rock);
    vec4 weights = vec4(1.0 - rock - sand, rock, sand * (1.0 - submerged), sand * submerged);

    // Grass: lush forest in damp hollows, pale and yellow where it is high, steep or exposed.
    float dry = smoothstep(frame.dry_height.x, frame.dry_height.y, above + 0.22 * frame.dry_height.x * (broad.x + hue.x));
    dry = max(dry, 0.8 * smoothstep(0.8 * frame.rock_slope.x, frame.rock_slope.y, steepness + 0.15 * hue.x));
    float hollow = 1.0 - smoothstep(0.6, 0.97, place.openness);
    float forest = smoothstep(-0.12, 0.12, 0.9 * broad.x + 0.3 * hue.x + 0.25 * trees.x + 1.2 * hollow + 0.3 - 1.1 * dry);
    forest *= frame.crowns;
    vec3 canopy = frame.grass * mix(vec3(0.36, 0.50, 0.40), vec3(0.58, 0.68, 0.34), clamp(0.5 + 0.8 * hue.x, 0.0, 1.0));
    vec3 meadow = frame.grass * (1.0 + 0.3 * hue.x + 0.15 * trees.x);
    vec3 grass = mix(meadow, frame.dry_grass * (1.0 + 0.25 * trees.x), dry);
    // Green and straw side by side; between tufts the soil shows.
    grass *= exp(litter.x * vec3(0.35, 0.16, 0.10) + 0.55 * min(grain.x, 0.3));
    // Between crowns it is dark.
    grass = mix(grass, canopy * exp(0.85 * clamp(trees.x, -1.0, 1.0)), forest);

    // Rock: beds some metres thick, warped and weathered; dark where it is wet.
    vec2 bed = vec2(place.point.y + 12.0 * broad.x + 3.0 * trees.x, 0.04 * (xz.x - xz.y));
    float strata = mottle(bed, 60.0, 6, 0.75, 2.0 * footprint, 71u).x;
    vec3 rock_colour = frame.rock * exp(0.3 * strata + 0.4 * trees.x + 0.25 * broad.x);
    rock_colour = mix(rock_colour, rock_colour * vec3(1.3, 0.97, 0.75), smoothstep(0.0, 0.7, hue.x));
    // Moss and scrub cling to it.
    rock_colour = mix(rock_colour, canopy, 0.55 * smoothstep(0.0, 0.5, 0.6 * trees.x - 0.5 * hue.x));
    rock_colour *= mix(1.0, 0.75, river);
    rock_colour *= exp(0.3 * litter.x + 0.45 * grain.x);

    // Sand darkens where waves wet it; debris lies along the line of the last flood.
    vec3 sand_colour = frame.sand * (1.0 + 0.08 * broad.x + 0.06 * trees.x);
    sand_colour *= exp(0.06 * litter.x + 0.12 * grain.x);
    sand_colour *= mix(0.66, 1.0, smoothstep(0.05, 0.45, above + 0.15 * trees.x));

    // Sea floor: sand with darker grass and rubble; coral where it grew, richest just below the surface.
    float rubble = smoothstep(0.05, 0.7, broad.x + 0.5 * trees.x);
    vec3 floor_colour = frame.sea_floor * (1.0 - 0.42 * rubble);
    // A reef's flat is mostly rubble and sand; coral is densest on the slope below it.
    float coral = smoothstep(0.4, 2.5, place.reef) * (1.0 - smoothstep(12.0, 35.0, -above));
    float cover = mix(-0.35, 0.5, smoothstep(0.7, 3.5, -above));
    coral *= smoothstep(-0.25, 0.25, 0.6 * hue.x + 0.7 * trees.x + cover);
    floor_colour = mix(floor_colour, frame.reef * (1.0 + 0.5 * trees.x), coral);

    // Ground below and rock above, whatever else there is (Rudzki 2020, section 3.3).
    // A choice of numbers that is compared with the place, and no branch on the frame alone: see `may_have_clouds`.
    float highest = frame.by_height.y > frame.by_height.x ? 1e30 : -1e30;
    bool by_height = place.point.y < highest;
    if (by_height) {
        float low = clamp((frame.by_height.y - place.point.y) / (frame.by_height.y - frame.by_height.x), 0.0, 1.0);
        weights = vec4(low, 1.0 - low, 0.0, 0.0);
        grass = tint_at(frame.low, place.point, footprint);
        rock_colour = tint_at(frame.high, place.point, footprint);
    }

    Ground found;
    found.weights = weights;
    found.albedo = weights.x * grass + weights.y * rock_colour + weights.z * sand_colour + weights.w * floor_colour;
    // Snow lies in patches first, and longest in hollows.
    float snow = smoothstep(frame.snow_height.x, frame.snow_height.y,
                            above + 0.3 * (frame.snow_height.y - frame.snow_height.x) * (broad.x + 0.4 * trees.x + hollow));
    snow *= 1.0 - smoothstep(frame.snow_slope.x, frame.snow_slope.y, steepness + 0.08 * trees.x);
    snow = smoothstep(0.3, 0.7, snow + 0.25 * (trees.x + 0.5 * litter.x) * snow * (1.0 - snow) * 4.0);
    found.albedo = mix(found.albedo, frame.snow * (1.0 + 0.04 * grain.x), snow);
    found.albedo = clamp(found.albedo, 0.0, 0.9);
    // Relief in metres: crowns, ledges, dunes, coral heads.
    vec2 relief = weights.x * (mix(0.6, 4.5, forest) * trees.yz + 1.5 * broad.yz)
                + weights.y * (3.0 * trees.yz + 5.0 * broad.yz) + weights.z * 0.25 * trees.yz
                + weights.w * (0.5 + 2.0 * coral) * trees.yz;
    relief += (0.05 * weights.x + 0.08 * weights.y + 0.015 * weights.z) * (grain.yz + 1.5 * litter.yz);
    relief *= by_height ? 0.0 : 1.0 - 0.8 * snow;
    // Near by, the finest relief would be all cliffs.
    relief /= 1.0 + 0.7 * length(relief);
    found.normal = normal_from_slope(place.slope + relief);
    return found;
}

#endif
