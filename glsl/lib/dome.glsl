// Looking for the sky where it is bright: a table over the sphere, constant in its cells. The includer declares the buffer
// `dome`, and `lib/sky.glsl` stands before.
#ifndef DOME_GLSL
#define DOME_GLSL

// Rows are bands of equal height, and so of equal solid angle, from straight up to straight down; columns are azimuths.
const int DOME_ROWS = 128;
const int DOME_COLUMNS = 128;
const float DOME_CELL = 4.0 * PI / float(DOME_ROWS * DOME_COLUMNS);

// `dome` holds how much of the light comes from above the end of each row, then the same within each row by column.
float dome_above(int row) {
    return row < 0 ? 0.0 : dome[row];
}

float dome_before(int row, int column) {
    return column < 0 ? 0.0 : dome[DOME_ROWS + row * DOME_COLUMNS + column];
}

ivec2 dome_cell(vec3 direction) {
    float turn = atan(direction.z, direction.x) / (2.0 * PI) + 0.5;
    int row = int((0.5 - 0.5 * direction.y) * float(DOME_ROWS));
    return clamp(ivec2(int(turn * float(DOME_COLUMNS)), row), ivec2(0), ivec2(DOME_COLUMNS - 1, DOME_ROWS - 1));
}

float cell_density(ivec2 cell) {
    float row = dome_above(cell.y) - dome_above(cell.y - 1);
    float column = dome_before(cell.y, cell.x) - dome_before(cell.y, cell.x - 1);
    return row * column / DOME_CELL;
}

// Of directions that `dome_direction` chooses, 1/sr.
float dome_density(vec3 direction) {
    return cell_density(dome_cell(direction));
}

// A direction in which there is light, and its density.
vec3 dome_direction(vec2 u, out float density) {
    int first = 0;
    int last = DOME_ROWS - 1;
    while (first < last) {
        int middle = (first + last) / 2;
        if (u.y < dome_above(middle)) last = middle; else first = middle + 1;
    }
    int row = first;
    float above = dome_above(row - 1);
    float down = clamp((u.y - above) / max(dome_above(row) - above, 1e-12), 0.0, 0.999999);
    first = 0;
    last = DOME_COLUMNS - 1;
    while (first < last) {
        int middle = (first + last) / 2;
        if (u.x < dome_before(row, middle)) last = middle; else first = middle + 1;
    }
    int column = first;
    float before = dome_before(row, column - 1);
    float along = clamp((u.x - before) / max(dome_before(row, column) - before, 1e-12), 0.0, 0.999999);
    density = cell_density(ivec2(column, row));
    float y = 1.0 - 2.0 * (float(row) + down) / float(DOME_ROWS);
    float azimuth = 2.0 * PI * ((float(column) + along) / float(DOME_COLUMNS) - 0.5);
    float level = sqrt(max(1.0 - y * y, 0.0));
    return vec3(level * cos(azimuth), y, level * sin(azimuth));
}

#endif
