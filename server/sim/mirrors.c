/* SPDX-License-Identifier: BSD-3-Clause */
/* Images of the fluid in mirrors. */
#include "sim/mirrors.h"
#include "sim/pairs.h"
#include "sim/sim.h"
#include <assert.h>
#include <math.h>

enum { SIDES = 6, LOWER_SIDES = 0x15 };

/* --- who is near them ------------------------------------------------------------------------------------------------------- */

bool mirrors_hide(const Model *model, const Particles *s, size_t i)
{
    if (!model->mirrors || i < particles_fluid(s)) return false;
    for (int side = 0; side < SIDES; side++)
        if (model->mirrors >> side & 1 && model_before_mirror(model, side, s->x[side / 2][i * s->x_step]) < 0)
            return true;
    return false;
}

unsigned mirrors_near(const Model *model, const double x[3], double distance)
{
    unsigned near = 0;
    for (int side = 0; side < SIDES; side++)
        if (model->mirrors >> side & 1 && model_before_mirror(model, side, x[side / 2]) < distance) near |= 1u << side;
    return near;
}

bool mirrors_make_image(unsigned these)
{
    return !(these & these >> 1 & LOWER_SIDES);
}

/* x_i - x_j' along d, the same for (i, j') as for (j, i') to the last bit. */
static double apart(const Model *model, unsigned these, int d, double x_i, double x_j)
{
    const int side = these >> 2 * d & 1 ? 2 * d : 2 * d + 1;
    const double sum = model_before_mirror(model, side, x_i) + model_before_mirror(model, side, x_j);
    return side % 2 ? -sum : sum;
}

static void place_of(const Particles *s, size_t i, MirroredWhen when, double ret[3])
{
    for (int d = 0; d < 3; d++)
        ret[d] = d >= s->dim ? 0 : when == MIRRORED_AS_LISTED ? s->ref[d][i] : s->x[d][i * s->x_step];
}

/* Has j an image by these sides within a distance of x_i? What a mirror hides has none. */
static bool has_image(const Model *model, const Particles *s, const double x_i[3], size_t j, unsigned these,
                      double distance, MirroredWhen when)
{
    double r2 = 0, x_j[3];
    place_of(s, j, when, x_j);
    if (j >= particles_fluid(s) && mirrors_near(model, x_j, 0)) return false;
    for (int d = 0; d < s->dim; d++) {
        const double x =
            these >> 2 * d & 3 ? apart(model, these, d, x_i[d], x_j[d]) : model_nearest(model, d, x_i[d] - x_j[d]);
        r2 += x * x;
    }
    return r2 < distance * distance;
}

size_t mirrors_count(const Model *model, const Particles *s, size_t i, const uint32_t *list, size_t n, double distance,
                     size_t most, MirroredWhen when)
{
    const bool own = i < particles_fluid(s);
    size_t images = 0;
    double x[3];
    place_of(s, i, when, x);
    const unsigned near = mirrors_near(model, x, distance);
    for (unsigned these = near & -near; these; these = (these - near) & near) { /* all that are part of it */
        if (!mirrors_make_image(these)) continue;
        images += own && images < most && has_image(model, s, x, i, these, distance, when);
        for (size_t k = 0; k < n && images < most; k++)
            images += has_image(model, s, x, list[k], these, distance, when);
    }
    return images;
}

size_t mirrors_thin(const Model *model, const Particles *s, uint32_t *list, size_t n)
{
    size_t left = 0;
    if (!model->mirrors) return n;
    for (size_t k = 0; k < n; k++) {
        double x[3];
        place_of(s, list[k], MIRRORED_AS_LISTED, x);
        list[left] = list[k];
        left += !mirrors_near(model, x, -0.5 * model->skin);
    }
    return left;
}

static size_t blocks_of(size_t pairs)
{
    return (pairs + LANES - 1) / LANES;
}

/* Is there room in a row for all images that there may be, if those in reach are counted? */
static bool have_room(const Model *model, const Particles *s, size_t i, const uint32_t *list, size_t fluid, size_t n,
                      double distance)
{
    const size_t own = blocks_of(fluid) + blocks_of(n - fluid),
                 images = mirrors_count(model, s, i, list, fluid, distance, SIZE_MAX, MIRRORED_AS_LISTED),
                 all = mirrors_count(model, s, i, list, n, distance, SIZE_MAX, MIRRORED_AS_LISTED);
    return own + blocks_of(images) + blocks_of(all - images) <= ROW_BLOCKS;
}

Mirrored mirrors_of_list(const Model *model, const Particles *s, size_t i, const uint32_t *list, size_t fluid, size_t n,
                         double distance)
{
    double x[3];
    if (!model->mirrors) return MIRRORED_NOT;
    place_of(s, i, MIRRORED_AS_LISTED, x);
    const unsigned near = mirrors_near(model, x, distance);
    if (!near || (i >= particles_fluid(s) && mirrors_near(model, x, 0))) return MIRRORED_NOT;
    if (n == fluid && !mirrors_count(model, s, i, list, n, distance, 1, MIRRORED_AS_LISTED)) return MIRRORED_NOT;
    size_t most = n + 1; /* with images by all sides */
    for (int d = 0; d < s->dim; d++) most *= 1 + (near >> 2 * d & 1) + (near >> (2 * d + 1) & 1);
    return blocks_of(most) + 4 <= ROW_BLOCKS || have_room(model, s, i, list, fluid, n, distance) ? MIRRORED
                                                                                                 : MIRRORED_TOO_OFTEN;
}

/* --- their rows ------------------------------------------------------------------------------------------------------------- */

/* A row that grows: the particle's place, mirrors within reach of it, and how many pairs there are so far. */
typedef struct Growing {
    Row *row;
    const RowPlan *plan;
    double x[3];
    unsigned near;
    size_t n;
} Growing;

/* Lanes of all blocks of a row. */
typedef struct Lengths {
    _Alignas(64) double of[ROW_BLOCKS][LANES];
    uint8_t marks[ROW_BLOCKS]; /* which of them are less than a limit, a bit each */
} Lengths;

static void mark(Lengths *lengths, size_t first, size_t last, double limit, const Model *model)
{
    select_marks(model->level, lengths->of[first], LANES, last - first, limit, lengths->marks + first);
}

/* --- which images there are --- */

/* Is the image by these sides of j in reach? Positions are those of the bundles, as the pass may move particles. from: the block in which j is in
 * lane l; NULL for the particle itself. */
INLINE bool reaches(const Growing *g, unsigned these, const Block *from, size_t l, uint32_t j)
{
    const RowPlan *plan = g->plan;
    double r2 = 0;
    for (int d = 0; d < plan->s->dim; d++) {
        double x = from ? from->x[d][l] : 0;
        if (these >> 2 * d & 3) x = apart(plan->model, these, d, g->x[d], plan->nb->bundles.data[0][j][d]);
        r2 += x * x;
    }
    return sqrt(r2) < plan->model->kernel.support;
}

/* A particle that has got behind a mirror has no image of its own, which would push it on. */
INLINE bool is_inside(const Model *model, unsigned these, const double x[3])
{
    for (int side = 0; side < SIDES; side++)
        if (these >> side & 1 && !(model_before_mirror(model, side, x[side / 2]) > 0)) return false;
    return true;
}

/* An image by these sides, from where a particle is: x_ij' = by + keeps x_ij along each direction. */
typedef struct Way {
    double by[3], keeps[3];
} Way;

INLINE Way way_of(const Model *model, unsigned these, const double x[3])
{
    Way way = {{0, 0, 0}, {1, 1, 1}};
    for (unsigned left = these; left; left &= left - 1) {
        const int side = __builtin_ctz(left);
        const double away = 2 * model_before_mirror(model, side, x[side / 2]);
        way.by[side / 2] = side % 2 ? -away : away;
        way.keeps[side / 2] = -1;
    }
    return way;
}

/* The squares of distances to images, but for rounding; of pairs that are not in reach themselves, too much. */
INLINE void measure(Lengths *r2, const Block *b, size_t k, const Way *way, double support, How how)
{
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        double sum = 0;
        for (int d = 0; d < how.dim; d++) {
            const double x = way->by[d] + way->keeps[d] * b->x[d][l];
            sum += x * x;
        }
        r2->of[k][l] = b->r[l] < support ? sum : 2 * support * support;
    }
}

/* An image is noted by its source, the pair of the row or OWN_IMAGE, and is made with those of its block. */
INLINE size_t note(Row *row, size_t n, unsigned these, size_t source, uint32_t j)
{
    row->j[n] = j;
    row->source[n] = (uint16_t)source;
    row->turned[n] = (uint8_t)these;
    return n + 1;
}

/* Limits to a square of a distance that rounding may have moved: what is less than the first is in reach, what is not less than the second is not. */
typedef struct Limits {
    double sure, most;
} Limits;

INLINE void note_own(Growing *g, unsigned these, const Way *way, const Limits *limits, How how)
{
    const uint32_t i = (uint32_t)g->row->i;
    const double r2 = DOT(way->by, way->by, how);
    if (!(r2 < limits->most) || !is_inside(g->plan->model, these, g->x)) return;
    if (r2 < limits->sure || reaches(g, these, NULL, 0, i)) g->n = note(g->row, g->n, these, OWN_IMAGE, i);
}

INLINE void note_block(Growing *g, unsigned these, size_t b, const Lengths *r2, const Limits *limits)
{
    Row *row = g->row;
    size_t n = g->n;
    for (unsigned left = r2->marks[b]; left; left &= left - 1) {
        const size_t l = (size_t)__builtin_ctz(left), k = b * LANES + l;
        if (r2->of[b][l] < limits->sure || reaches(g, these, row->block + b, l, row->j[k]))
            n = note(row, n, these, k, row->j[k]);
    }
    assert(n <= (size_t)ROW_BLOCKS * LANES);
    g->n = n;
}

/* Of the pairs of blocks [first, last). */
INLINE void note_images(Growing *g, size_t first, size_t last, bool own, How how)
{
    const Row *row = g->row;
    const Model *model = g->plan->model;
    const double support = model->kernel.support, square = support * support;
    const Limits limits = {0.9999 * square, 1.0001 * square};
    Lengths r2;
    for (unsigned these = g->near & -g->near; these; these = (these - g->near) & g->near) {
        if (!mirrors_make_image(these)) continue;
        const Way way = way_of(model, these, g->x);
        if (own) note_own(g, these, &way, &limits, how);
        for (size_t b = first; b < last; b++) measure(&r2, row->block + b, b, &way, support, how);
        mark(&r2, first, last, limits.most, model);
        for (size_t b = first; b < last; b++) note_block(g, these, b, &r2, &limits);
    }
}

/* --- what they are like --- */

/* Turn component d of what is needed of the neighbours. */
INLINE void turn(Block *b, int d, const double keeps[LANES], unsigned needs)
{
#pragma omp simd
    for (int l = 0; l < LANES; l++) b->v[d][l] *= keeps[l];
    if (needs & NEED_GRADIENT)
#pragma omp simd
        for (int l = 0; l < LANES; l++) b->gradient[d][l] *= keeps[l];
    if (needs & NEED_NORMAL)
#pragma omp simd
        for (int l = 0; l < LANES; l++) b->normal[d][l] *= keeps[l];
    for (int k = 0; k < 3 && needs & NEED_STRAIN; k++) /* xy, xz, yz */
        if (k != 2 - d)
#pragma omp simd
            for (int l = 0; l < LANES; l++) b->normal[k][l] *= keeps[l];
}

/* From positions in direction d to differences to them, as apart() and rows have them. */
INLINE void reflect(Block *b, int d, const uint8_t turned[LANES], const Growing *g, unsigned needs)
{
    const Model *model = g->plan->model;
    const int side = 2 * d;
    const double x = g->x[d], lower = model->mirror_at[side], upper = model->mirror_at[side + 1];
    double keeps[LANES];
    uint64_t all; /* a byte each */
    memcpy(&all, turned, sizeof all);
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        const uint64_t sides = all >> (8 * l + 2 * d) & 3;
        const double at = sides == 0 ? 0 : sides == 1 ? lower : upper;
        keeps[l] = sides == 0 ? 1 : -1;
        b->x[d][l] = (x - at) - keeps[l] * (b->x[d][l] - at);
    }
    turn(b, d, keeps, needs);
}

INLINE void fill_image_block(Block *b, const Growing *g, unsigned needs, How how)
{
    const RowPlan *plan = g->plan;
    const size_t first = (size_t)(b - g->row->block) * LANES;
    double r2[LANES];
    fetch_block(b, g->row->j + first, &plan->nb->bundles, needs, how);
    for (int d = 0; d < how.dim; d++)
        if (g->near >> 2 * d & 3) reflect(b, d, g->row->turned + first, g, needs);
        else
#pragma omp simd
            for (int l = 0; l < LANES; l++) b->x[d][l] = nearest(plan->model, g->x[d] - b->x[d][l], d, how);
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        double sum = 0;
        for (int d = 0; d < how.dim; d++) sum += b->x[d][l] * b->x[d][l];
        b->r[l] = sqrt(sum);
        r2[l] = b->r[l] * b->r[l];
    }
    how.fma = false;
    fill_kernel(b, r2, plan, how);
}

/* Make what has been noted from a block on, and fill up the last block with its last pair, out of reach; returns how many blocks there are. */
INLINE size_t fill_images(Growing *g, size_t first, How how)
{
    Row *row = g->row;
    const RowPlan *plan = g->plan;
    const size_t used = g->n;
    while (g->n % LANES) g->n = note(row, g->n, 0, OWN_IMAGE, row->j[g->n - 1]);
    Block *const end = row->block + g->n / LANES;
    const unsigned needs = plan->needs;
    for (Block *b = row->block + first; b < end; b++) {
        fill_image_block(b, g, needs, how);
        if (row->mixed) find_others(plan->s->phase, plan->s->phase[row->i], row_j(row, b), b->other);
    }
    if (used % LANES) hide(end - 1, used, 2 * plan->model->kernel.support);
    return g->n / LANES;
}

/* --- walls --- */

/* How far pairs are, and too far what is behind a mirror. What is in reach and behind one is behind one within reach of the particle. */
INLINE void measure_before(double r[LANES], const Block *b, const Growing *g)
{
    const Model *model = g->plan->model;
    const double far = 2 * model->kernel.support;
    memcpy(r, b->r, sizeof b->r);
    for (unsigned left = g->near; left; left &= left - 1) {
        const int side = __builtin_ctz(left), d = side / 2;
        const double inside = model_before_mirror(model, side, g->x[d]), sign = side % 2 ? 1 : -1;
#pragma omp simd
        for (int l = 0; l < LANES; l++) r[l] = inside + sign * b->x[d][l] < 0 ? far : r[l];
    }
}

/* Walls in reach that are not behind a mirror, and are marked alone; returns how many. Images of fluid go where they are. j: [PICKED_MAX] */
INLINE size_t shown_walls(const Growing *g, uint32_t *j)
{
    const Row *row = g->row;
    const Model *model = g->plan->model;
    Lengths r;
    for (size_t b = row->n_fluid; b < row->n; b++) measure_before(r.of[b], row->block + b, g);
    mark(&r, row->n_fluid, row->n, model->kernel.support, model);
    const size_t blocks = row->n - row->n_fluid;
    if (g->plan->pairs == ROW_LISTED)
        memcpy(neighbours_marks(g->plan->nb, row->i) + row->n_fluid, r.marks + row->n_fluid, blocks);
    return select_marked(model->level, row->j + row->n_fluid * LANES, blocks * LANES, r.marks + row->n_fluid, j);
}

/* After the images of fluid; returns how many blocks there are. */
INLINE size_t append_walls(Growing *g, const uint32_t *j, size_t n, How how)
{
    Row *row = g->row;
    memcpy(row->j + g->n, j, n * sizeof *j);
    const size_t end = row->n_fluid + fill_up(row->j + g->n, n);
    assert(end <= ROW_BLOCKS);
    const unsigned needs = g->plan->needs;
    for (size_t b = row->n_fluid; b < end; b++)
        fill_block(row->block + b, row->j + b * LANES, g->plan, needs, g->x, how);
    hide(row->block + end - 1, n, 2 * g->plan->model->kernel.support);
    g->n = end * LANES;
    return end;
}

INLINE void add_images(Row *row, const RowPlan *plan, How how)
{
    const Particles *s = plan->s;
    uint32_t walls[PICKED_MAX];
    Growing g = {.row = row, .plan = plan, .n = row->n_fluid * LANES};
    for (int d = 0; d < how.dim; d++) g.x[d] = s->x[d][row->i * s->x_step];
    g.near = mirrors_near(plan->model, g.x, plan->model->kernel.support);
    const size_t n_walls = row->n > row->n_fluid ? shown_walls(&g, walls) : 0;
    row->n_own = row->n_fluid;
    note_images(&g, 0, row->n_own, row->i < particles_fluid(s), how);
    row->n = row->n_walls = row->n_fluid = fill_images(&g, row->n_own, how);
    if (!n_walls) return;
    row->n_walls = append_walls(&g, walls, n_walls, how);
    note_images(&g, row->n_fluid, row->n_walls, false, how);
    row->n = fill_images(&g, row->n_walls, how);
}

INLINE void add(Row *row, const RowPlan *plan, size_t i, How how)
{
    (void)i;
    how.periodic = true;
#ifndef MENISCUS_SANITIZED
#define ADD(shape)                                                                                                     \
    how.kernel = shape;                                                                                                \
    add_images(row, plan, how)
    WITH_KERNEL(plan->model->kernel.type, ADD)
#else
    how.kernel = kernel_shape_of(plan->model->kernel.type);
    add_images(row, plan, how);
#endif
}
ROW_BUILDERS(add)

void mirrors_add(Row *row, const RowPlan *plan)
{
    static const RowBuilder builders[LEVELS][2] = ROW_TABLE(add);
    builders[plan->model->level][plan->s->dim - 2](row, plan, row->i);
}
