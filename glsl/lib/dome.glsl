// Looking for the sky where it is bright: a table over the sphere, constant in its cells. The includer declares the buffer
// `dome`, and `lib/sky.glsl` stands before.
#ifndef DOME_GLSL
#define DOME_GLSL

// Rows are bands of equal angle from straight up to straight down, as those of pictures are; columns are azimuths, clockwise from
// north. `dome` holds how much of the light comes from above the end of each row, then the same within each row by column.
float dome_above(int row) {
    return row < 0 ? 0.0 : dome[row];
}

float dome_before(int row, int column) {
    return column < 0 ? 0.0 : dome[frame.dome_size.y + row * frame.dome_size.x + column];
}

ivec2 dome_cell(vec3 direction) {
    float turn = fract(atan(direction.x, -direction.z) / (2.0 * PI));
    ivec2 cell = ivec2(vec2(turn, from_zenith(direction)) * vec2(frame.dome_size));
    return clamp(cell, ivec2(0), frame.dome_size - 1);
}

// Heights of the upper edge of a row, and how far below it the lower one is: cos a − cos b, without the difference.
vec2 dome_band(int row) {
    float step_ = 0.5 / float(frame.dome_size.y);
    float middle = accurate_cos_sin((float(row) + 0.5) * step_).y;
    return vec2(accurate_cos_sin(float(row) * step_).x, 2.0 * middle * accurate_cos_sin(0.5 * step_).y);
}

float cell_density(ivec2 cell) {
    float row = dome_above(cell.y) - dome_above(cell.y - 1);
    float column = dome_before(cell.y, cell.x) - dome_before(cell.y, cell.x - 1);
    return row * column * float(frame.dome_size.x) / (2.0 * PI * dome_band(cell.y).y);
}

// Of directions that `dome_direction` chooses, 1/sr.
float dome_density(vec3 direction) {
    return cell_density(dome_cell(direction));
}

// A direction in which there is light, and its density.
vec3 dome_direction(vec2 u, out float density) {
    int first = 0;
    int last = frame.dome_size.y - 1;
    while (first < last) {
        int middle = (first + last) / 2;
        if (u.y < dome_above(middle)) last = middle; else first = middle + 1;
    }
    int row = first;
    float above = dome_above(row - 1);
    float down = clamp((u.y - above) / max(dome_above(row) - above, 1e-12), 0.0, 0.999999);
    first = 0;
    last = frame.dome_size.x - 1;
    while (first < last) {
        int middle = (first + last) / 2;
        if (u.x < dome_before(row, middle)) last = middle; else first = middle + 1;
    }
    int column = first;
    float before = dome_before(row, column - 1);
    float along = clamp((u.x - before) / max(dome_before(row, column) - before, 1e-12), 0.0, 0.999999);
    density = cell_density(ivec2(column, row));
    vec2 band = dome_band(row);
    float y = band.x - down * band.y;
    vec2 azimuth = accurate_cos_sin((float(column) + along) / float(frame.dome_size.x));
    float level = sqrt(max(1.0 - y * y, 0.0));
    return vec3(level * azimuth.y, y, -level * azimuth.x);
}

#endif
