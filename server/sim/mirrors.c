/* SPDX-License-Identifier: BSD-3-Clause */
/* Sides of the domain that mirror the fluid: which they are, and images in them. */
#include "sim/mirrors.h"
#include "sim/pairs.h"
#include "sim/sim.h"
#include <assert.h>
#include <math.h>

enum { SIDES = 6, ALL_SIDES = (1 << SIDES) - 1, LOWER_SIDES = 0x15 };

/* Of a spacing: how near to a side of the domain the surface of a wall has to be. */
static const double FLUSH = 1e-3;

/* --- which sides are mirrors ------------------------------------------------------------------------------------------------ */

static bool slips_and_stays(const MnsSim *sim, size_t wall)
{
    const WallState *state = &sim->model.wall[wall];
    return !state->no_slip && !state->has_belt && sim->c->walls[wall].motion.kind == MNS_STILL;
}

/* Is a place inside of a wall, and of none that is no mirror? */
static bool is_backed(const MnsSim *sim, const double x[3])
{
    bool any = false;
    for (size_t k = 0; k < sim->model.n_walls; k++) {
        if (!(shape_distance(&sim->solid[k], x) < 0)) continue;
        if (!slips_and_stays(sim, k)) return false;
        any = true;
    }
    return any;
}

static bool is_open(const MnsSim *sim, const double x[3])
{
    for (size_t k = 0; k < sim->model.n_walls; k++)
        if (shape_distance(&sim->solid[k], x) < 0) return false;
    return true;
}

/* By what lies just behind each cell of the lattice that is beside it; and somewhere there is fluid before it. */
static bool is_mirror(const MnsSim *sim, int side)
{
    const Model *model = &sim->model;
    const int d = side / 2, e = (d + 1) % model->dim, f = model->dim == 3 ? (d + 2) % 3 : e;
    const double at = side % 2 ? model->max[d] : model->min[d], behind = (side % 2 ? 1 : -1) * FLUSH * model->dx;
    size_t n[3] = {1, 1, 1};
    for (int k = 0; k < model->dim; k++) n[k] = (size_t)lround((model->max[k] - model->min[k]) / model->cell[k]);
    bool open = false;
    if (model->period[d] > 0) return false;
    for (size_t b = 0; b < (f == e ? 1 : n[f]); b++)
        for (size_t a = 0; a < n[e]; a++) {
            double x[3] = {0, 0, 0};
            x[f] = model->min[f] + ((double)b + 0.5) * model->cell[f];
            x[e] = model->min[e] + ((double)a + 0.5) * model->cell[e];
            x[d] = at + behind;
            if (!is_backed(sim, x)) return false;
            x[d] = at - behind;
            open = open || is_open(sim, x);
        }
    return open;
}

/* Has gravity no part along d, ever? */
static bool is_weightless(const Formula *gravity)
{
    const double t = 0;
    return formula_is_constant(gravity) && formula_eval(gravity, &t) == 0;
}

static bool any_slips(const MnsSim *sim)
{
    for (size_t k = 0; k < sim->model.n_walls; k++)
        if (slips_and_stays(sim, k)) return true;
    return false;
}

/* Does a row have room for all listed neighbours on a lattice and a tenth denser, where these mirrors meet: fluid, images of the rest of the ball, and
 * the wall particles that these stand for? */
static bool have_room_in_corners(const Model *model, unsigned mirrors)
{
    const double reach = model->kernel.support + model->skin, pi = acos(-1),
                 ball = model->dim == 2 ? pi * reach * reach : 4 * pi / 3 * reach * reach * reach;
    double fluid = 1;
    for (int d = 0; d < model->dim; d++) fluid *= mirrors >> 2 * d & 3 ? 0.5 : 1;
    return 1.1 * (2 - fluid) * ball / model->cell_volume <= ROW_MAX;
}

unsigned mirrors_find(const MnsSim *sim, Formula *const gravity[3])
{
    const Model *model = &sim->model;
    unsigned mirrors = 0;
    for (int side = 0; side < 2 * model->dim && any_slips(sim); side++)
        if ((sim->scheme->floors_mirror || is_weightless(gravity[side / 2])) && is_mirror(sim, side))
            mirrors |= 1u << side;
    for (int d = 0; d < model->dim; d++)
        if ((mirrors >> 2 * d & 3) == 3 && model->max[d] - model->min[d] < model->kernel.support)
            mirrors &= ~(3u << 2 * d);
    return have_room_in_corners(model, mirrors) ? mirrors : 0;
}

bool mirrors_have(const Model *model, const Face *face)
{
    for (int d = 0; d < model->dim; d++) {
        const int side = face->normal[d] > 0 ? 2 * d : 2 * d + 1;
        const double at = face->point[d] + model->wall[face->wall].x[d];
        if (!(model->mirrors >> side & 1) || !(fabs(face->normal[d]) > 1 - 1e-9)) continue;
        if (fabs(model_inside(model, side, at)) < FLUSH * model->dx) return true;
    }
    return false;
}

/* --- who is near them ------------------------------------------------------------------------------------------------------- */

bool mirrors_hide(const Model *model, const Particles *s, size_t i)
{
    if (!model->mirrors || i < particles_fluid(s)) return false;
    for (int side = 0; side < SIDES; side++)
        if (model->mirrors >> side & 1 && model_inside(model, side, s->x[side / 2][i * s->x_step]) < 0) return true;
    return false;
}

/* Mirrors nearer than this to a place, a bit each. */
static unsigned near_to(const Model *model, const double x[3], double distance)
{
    unsigned near = 0;
    for (int side = 0; side < SIDES; side++)
        if (model->mirrors >> side & 1 && model_inside(model, side, x[side / 2]) < distance) near |= 1u << side;
    return near;
}

bool mirrors_are_near(const Model *model, const Particles *s, size_t i, double distance)
{
    double x[3] = {0, 0, 0};
    if (!model->mirrors) return false;
    for (int d = 0; d < s->dim; d++) x[d] = s->ref[d][i];
    return near_to(model, x, distance) && (i < particles_fluid(s) || !near_to(model, x, 0));
}

/* Are these sides of `near` some by which there is an image? One of each direction: behind both there are only images that are out of reach. */
static bool is_image(unsigned these, unsigned near)
{
    return these && !(these & ~near) && !(these & these >> 1 & LOWER_SIDES);
}

/* x_i - x_j' along d, the same for (i, j') as for (j, i') to the last bit. */
static double apart(const Model *model, unsigned these, int d, double x_i, double x_j)
{
    const int side = these >> 2 * d & 1 ? 2 * d : 2 * d + 1;
    const double sum = model_inside(model, side, x_i) + model_inside(model, side, x_j);
    return side % 2 ? -sum : sum;
}

/* Neighbours [first, last) of a list that have an image by these sides within a distance of i, by where they were when lists were made. */
static size_t count_images(const Model *model, const Particles *s, size_t i, const uint32_t *list, size_t first,
                           size_t last, unsigned these, double distance)
{
    size_t n = 0;
    for (size_t k = first; k < last; k++) {
        double r2 = 0;
        for (int d = 0; d < s->dim; d++) {
            const double x_i = s->ref[d][i], x_j = s->ref[d][list[k]];
            const double x = these >> 2 * d & 3 ? apart(model, these, d, x_i, x_j) : model_nearest(model, d, x_i - x_j);
            r2 += x * x;
        }
        n += r2 < distance * distance;
    }
    return n;
}

static size_t blocks_of(size_t pairs)
{
    return (pairs + LANES - 1) / LANES;
}

bool mirrors_have_room(const Model *model, const Particles *s, size_t i, const uint32_t *list, size_t fluid, size_t n,
                       double distance)
{
    double x[3] = {0, 0, 0};
    size_t images = 0, wall_images = 0;
    for (int d = 0; d < s->dim; d++) x[d] = s->ref[d][i];
    const unsigned near = near_to(model, x, distance);
    for (unsigned these = 1; these <= ALL_SIDES; these++) {
        if (!is_image(these, near)) continue;
        images += 1 + count_images(model, s, i, list, 0, fluid, these, distance);
        wall_images += count_images(model, s, i, list, fluid, n, these, distance);
    }
    return blocks_of(fluid) + blocks_of(images) + blocks_of(n - fluid) + blocks_of(wall_images) <= ROW_BLOCKS;
}

/* --- their rows ------------------------------------------------------------------------------------------------------------- */

/* A row that grows, pair by pair. */
typedef struct Growing {
    Row *row;
    const RowPlan *plan;
    double x[3]; /* of the particle */
    size_t n;    /* pairs so far */
} Growing;

enum { ARRAYS = sizeof(Block) / (LANES * sizeof(double)) };
_Static_assert(sizeof(Block) == sizeof(double) * ARRAYS * LANES, "a block is all of arrays of eight numbers");

static void copy_pair(Block *to, size_t l, const Block *from, size_t k)
{
    double(*its)[LANES] = (double(*)[LANES])to;
    const double(*mine)[LANES] = (const double(*)[LANES])from;
    for (size_t q = 0; q < ARRAYS; q++) its[q][l] = mine[q][k];
}

/* What bundle k has of j, in lane l. */
INLINE void fetch_one(Block *to, size_t l, const double (*bundle)[4], uint32_t j, int dim, int k)
{
    const uint8_t *what = BUNDLE_LAYOUT[dim - 2][k];
    double *const at[4] = {place(to, what[0]), place(to, what[1]), place(to, what[2]), place(to, what[3])};
    if (at[0]) at[0][l] = bundle[j][0];
    if (at[1]) at[1][l] = bundle[j][1];
    if (at[2]) at[2][l] = bundle[j][2];
    if (at[3]) at[3][l] = bundle[j][3];
}

/* All that is needed of j, as rows have it. */
INLINE void fetch(Block *to, size_t l, const RowPlan *plan, uint32_t j, int dim)
{
    const Bundles *bundles = &plan->nb->bundles;
    fetch_one(to, l, bundles->data[0], j, dim, 0);
    if (plan->needs & bundle_meets(dim, 1)) fetch_one(to, l, bundles->data[1], j, dim, 1);
    if (plan->needs & bundle_meets(dim, 2)) fetch_one(to, l, bundles->data[2], j, dim, 2);
    if (plan->needs & bundle_meets(dim, 3)) fetch_one(to, l, bundles->data[3], j, dim, 3);
}

static void fetch_pair(Block *to, size_t l, const RowPlan *plan, uint32_t j)
{
    if (plan->s->dim == 2) fetch(to, l, plan, j, 2);
    else fetch(to, l, plan, j, 3);
}

/* The place of the next pair. */
static Block *next(const Growing *g, size_t *ret_lane)
{
    assert(g->n < (size_t)ROW_BLOCKS * LANES);
    *ret_lane = g->n % LANES;
    return g->row->block + g->n / LANES;
}

/* Component d of all vectors of a pair. */
static void turn(Block *b, size_t l, int d, const RowPlan *plan)
{
    b->v[d][l] = -b->v[d][l];
    if (plan->needs & NEED_FLUX) { /* which is where others have gradients and normals */
        double *flux = FLUX_OF(b, d, plan->s->dim);
        flux[l] = -flux[l];
        return;
    }
    b->gradient[d][l] = -b->gradient[d][l];
    b->normal[d][l] = -b->normal[d][l];
}

/* The image by these sides of j, of which `from` is the pair k of the row, NULL for the particle itself; nothing where it is out of reach.
 * Positions are those of the bundles, as the pass may move particles. */
static void append_image(Growing *g, unsigned these, const Block *from, size_t k, uint32_t j)
{
    const RowPlan *plan = g->plan;
    const int dim = plan->s->dim;
    double x[3] = {0, 0, 0}, r2 = 0;
    for (int d = 0; d < dim; d++) {
        x[d] = from ? from->x[d][k % LANES] : 0;
        if (these >> 2 * d & 3) x[d] = apart(plan->model, these, d, g->x[d], plan->nb->bundles.data[0][j][d]);
        r2 += x[d] * x[d];
    }
    const double r = sqrt(r2);
    if (!(r < plan->model->kernel.support)) return;
    size_t l;
    Block *b = next(g, &l);
    fetch_pair(b, l, plan, j);
    for (int d = 0; d < dim; d++) {
        b->x[d][l] = x[d];
        if (these >> 2 * d & 3) turn(b, l, d, plan);
    }
    b->r[l] = r;
    b->other[l] = from ? from->other[k % LANES] : 0;
    g->row->j[g->n] = j;
    g->row->source[g->n] = (uint16_t)(from ? k : OWN_IMAGE);
    g->row->turned[g->n++] = (uint8_t)these;
}

/* A particle that has got behind a mirror has no image of its own, which would push it on. */
static bool is_inside(const Model *model, unsigned these, const double x[3])
{
    for (int side = 0; side < SIDES; side++)
        if (these >> side & 1 && !(model_inside(model, side, x[side / 2]) > 0)) return false;
    return true;
}

/* An image by these sides, from where a particle is: x_ij' = by + keeps x_ij along each direction. */
typedef struct Way {
    double by[3], keeps[3];
} Way;

static Way way_of(const Model *model, unsigned these, const double x[3])
{
    Way way = {{0, 0, 0}, {1, 1, 1}};
    for (int side = 0; side < SIDES; side++) {
        if (!(these >> side & 1)) continue;
        const double away = 2 * model_inside(model, side, x[side / 2]);
        way.by[side / 2] = side % 2 ? -away : away;
        way.keeps[side / 2] = -1;
    }
    return way;
}

/* Which pairs of a block are in reach and have an image that is, but for rounding; a bit each. */
static unsigned within(const Block *b, const Way *way, int dim, double support)
{
    double r2[LANES] = {0};
    for (int d = 0; d < dim; d++)
        for (int l = 0; l < LANES; l++) {
            const double x = way->by[d] + way->keeps[d] * b->x[d][l];
            r2[l] += x * x;
        }
    unsigned ret = 0;
    for (int l = 0; l < LANES; l++) ret |= (unsigned)(b->r[l] < support && r2[l] < 1.0001 * support * support) << l;
    return ret;
}

/* Of the pairs of blocks [first, last). */
static void append_images(Growing *g, unsigned near, size_t first, size_t last, bool own)
{
    Row *row = g->row;
    const Model *model = g->plan->model;
    for (unsigned these = 1; these <= ALL_SIDES; these++) {
        if (!is_image(these, near)) continue;
        const Way way = way_of(model, these, g->x);
        if (own && is_inside(model, these, g->x)) append_image(g, these, NULL, 0, (uint32_t)row->i);
        for (size_t b = first; b < last; b++)
            for (unsigned left = within(row->block + b, &way, model->dim, model->kernel.support); left;
                 left &= left - 1) {
                const size_t k = b * LANES + (size_t)__builtin_ctz(left);
                append_image(g, these, row->block + b, k, row->j[k]);
            }
    }
}

/* Walls that are not behind a mirror, put by: images of fluid go where they are. */
typedef struct Walls {
    size_t n;
    uint32_t j[PICKED_MAX];
    Block block[ROW_BLOCKS];
} Walls;

/* Which pairs of a block are in reach and before all of these mirrors, of the particle at x; a bit each. What is in reach and behind a mirror is
 * behind one within reach of the particle. */
static unsigned before(const Block *b, const Model *model, unsigned near, const double x[3])
{
    double least[LANES] = {0};
    for (unsigned left = near; left; left &= left - 1) {
        const int side = __builtin_ctz(left), d = side / 2;
        const double inside = model_inside(model, side, x[d]), sign = side % 2 ? 1 : -1;
        for (int l = 0; l < LANES; l++) {
            const double its = inside + sign * b->x[d][l];
            least[l] = its < least[l] ? its : least[l];
        }
    }
    unsigned ret = 0;
    for (int l = 0; l < LANES; l++) ret |= (unsigned)(b->r[l] < model->kernel.support && !(least[l] < 0)) << l;
    return ret;
}

static void put_by(Walls *walls, const Row *row, const RowPlan *plan, unsigned near, const double x[3])
{
    walls->n = 0;
    for (size_t b = row->n_fluid; b < row->n; b++)
        for (unsigned left = before(row->block + b, plan->model, near, x); left; left &= left - 1) {
            const size_t l = (size_t)__builtin_ctz(left);
            copy_pair(walls->block + walls->n / LANES, walls->n % LANES, row->block + b, l);
            walls->j[walls->n++] = row->j[b * LANES + l];
        }
}

static void append_walls(Growing *g, const Walls *walls)
{
    for (size_t k = 0; k < walls->n; k++) {
        size_t l;
        Block *b = next(g, &l);
        copy_pair(b, l, walls->block + k / LANES, k % LANES);
        g->row->j[g->n++] = walls->j[k];
    }
}

/* Fill up the last block with its last pair, out of reach; returns how many blocks there are. */
static size_t fill_block_up(Growing *g)
{
    while (g->n % LANES) {
        size_t l;
        Block *b = next(g, &l);
        const uint32_t j = g->row->j[g->n - 1];
        fetch_pair(b, l, g->plan, j);
        b->r[l] = 2 * g->plan->model->kernel.support;
        b->W[l] = b->F[l] = b->bend[l] = b->other[l] = 0;
        g->row->j[g->n] = j;
        g->row->source[g->n] = OWN_IMAGE;
        g->row->turned[g->n++] = 0;
    }
    return g->n / LANES;
}

static void find_kernels(const Growing *g, size_t first, size_t last)
{
    const Kernel *kernel = &g->plan->model->kernel;
    for (Block *b = g->row->block + first; b < g->row->block + last; b++) {
        kernel_eval(kernel, LANES, b->r, b->W, b->F);
        if (g->plan->needs & NEED_BEND) kernel_bend(kernel, LANES, b->r, b->bend);
    }
}

void mirrors_add(Row *row, const RowPlan *plan)
{
    const Particles *s = plan->s;
    Walls walls;
    Growing g = {.row = row, .plan = plan, .n = row->n_fluid * LANES};
    for (int d = 0; d < s->dim; d++) g.x[d] = s->x[d][row->i * s->x_step];
    const unsigned near = near_to(plan->model, g.x, plan->model->kernel.support);
    put_by(&walls, row, plan, near, g.x);
    row->n_own = row->n_fluid;
    append_images(&g, near, 0, row->n_own, row->i < particles_fluid(s));
    row->n_fluid = fill_block_up(&g);
    find_kernels(&g, row->n_own, row->n_fluid);
    append_walls(&g, &walls);
    row->n_walls = fill_block_up(&g);
    append_images(&g, near, row->n_fluid, row->n_walls, false);
    row->n = fill_block_up(&g);
    find_kernels(&g, row->n_walls, row->n);
}
