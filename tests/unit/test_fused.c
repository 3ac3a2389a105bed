/* SPDX-License-Identifier: BSD-3-Clause */
/* What is fused gives the same bits as its terms one after the other, for every kernel, dimension and level of instructions. */
#include "sim/fused.h"
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include "tests/support/sims.h"
#include <stdlib.h>
#include <string.h>

static int three_kinds(const double x[3])
{
    if (x[1] < 0.25 + 0.1 * x[0]) return CLOUD_WALL;
    return x[0] + 0.3 * x[1] < 0.5 ? CLOUD_WATER : CLOUD_AIR;
}

/* What a cloud is made of and how its pass is run. */
typedef struct Mode {
    int dim;
    MnsKernel kernel;
    bool periodic, marked, stressed, reconstructs;
    Spared spared;
    Level level;
} Mode;

static Cloud *stirred(const Mode *mode)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = mode->dim,
                                           .dx = 0.1,
                                           .n = {11, 10, 9},
                                           .jitter = 0.4,
                                           .skin = 0.3,
                                           .periodic = {mode->periodic, false, mode->periodic},
                                           .kernel = mode->kernel,
                                           .smoothing = mode->kernel == MNS_WENDLAND_C2 ? 1.3 : 1.0,
                                           .reconstructs = mode->reconstructs,
                                           .owner = three_kinds});
    Particles *s = &cloud->s;
    uint64_t seed = 77;
    cloud_stir(cloud, 5);
    for (int d = 0; d < mode->dim; d++)
        for (size_t i = 0; i < s->n; i++) s->b[d][i] = 800 * cloud_noise(&seed);
    for (int d = 0; d < mode->dim && mode->reconstructs; d++)
        for (size_t i = 0; i < s->n; i++) {
            s->strain[d][i] = 20 * cloud_noise(&seed);
            s->strain_off[d][i] = 20 * cloud_noise(&seed);
            s->gradient[d][i] = 2000 * cloud_noise(&seed);
        }
    for (int d = 0; d < mode->dim; d++) cloud->model.gravity[d] = -2 - d;
    cloud->model.spared = mode->spared;
    for (size_t a = 0; a < 2; a++)
        for (size_t w = 0; w < s->n - particles_fluid(s); w++) s->p_wall[a][w] = 100 * cloud_noise(&seed);
    return cloud;
}

enum { ROWS = 16 };

/* What terms write, row by row: [ROWS * n], yours. */
static double *written(const Particles *s)
{
    double *all = calloc(ROWS * s->n, sizeof *all);
    assert_non_null(all);
    for (int d = 0; d < s->dim; d++) {
        memcpy(all + (size_t)d * s->n, s->a[d], s->n * sizeof *all);
        memcpy(all + (size_t)(3 + d) * s->n, s->b[d], s->n * sizeof *all);
        memcpy(all + (size_t)(13 + d) * s->n, s->gradient[d], s->n * sizeof *all);
        if (!s->strain[d]) continue;
        memcpy(all + (size_t)(7 + d) * s->n, s->strain[d], s->n * sizeof *all);
        if (s->strain_off[d]) memcpy(all + (size_t)(10 + d) * s->n, s->strain_off[d], s->n * sizeof *all);
    }
    memcpy(all + 6 * s->n, s->rate, s->n * sizeof *all);
    return all;
}

/* Say that all has changed: the positions too, which takes marks away, or all but them. The next pass shall find what is said here. */
static void change(Cloud *cloud, bool marked)
{
    particles_changed(&cloud->s, ON_ALL, marked ? ALL_FIELDS & ~FIELD(X) : ALL_FIELDS);
    neighbours_refresh(&cloud->nb, &cloud->s, &cloud->model, 0);
    assert_int_equal(cloud->nb.marked & ON_FLUID, marked ? ON_FLUID : 0);
}

/* What is fused, how often it was asked for, and of which pairs it shall be asked. */
static struct Counted {
    FusedFunction function;
    RowPairs pairs;
    size_t calls;
} counted;

static void count(const RowPlan *plan, Particles *s, size_t i)
{
    counted.calls++;
    assert_int_equal(plan->pairs, counted.pairs);
    counted.function(plan, s, i);
}

/* A copy of which calls are counted, if there is a function of this level at all. */
static Fusion watched(const Fusion *fusion, int dim, bool marked, Level level)
{
    Fusion copy = *fusion;
    counted = (struct Counted){fusion->row[level][dim - 2], marked ? ROW_MARKED : ROW_LISTED, 0};
    if (counted.function) copy.row[level][dim - 2] = count;
    return copy;
}

/* One pass over a new cloud: with pairs that were marked before, or with all that are listed. */
static double *result_of(const Pass *pass, const Mode *mode, size_t *ret_n)
{
    Cloud *cloud = stirred(mode);
    cloud->model.transport_stress = mode->stressed;
    const Pass first = {"marks", .terms = {mode->reconstructs ? &reconstructed_momentum : &riemann_momentum}};
    cloud->model.level = mode->level;
    if (mode->marked) pass_run(&first, &cloud->s, &cloud->nb, &cloud->model, 1);
    for (size_t i = 0; i < cloud->s.n; i++) cloud->s.rate[i] = 0;
    for (int d = 0; d < mode->dim; d++)
        for (size_t i = 0; i < cloud->s.n; i++) cloud->s.a[d][i] = 0;
    change(cloud, mode->marked);
    pass_run(pass, &cloud->s, &cloud->nb, &cloud->model, 1);
    double *all = written(&cloud->s);
    *ret_n = cloud->s.n;
    cloud_free(cloud);
    return all;
}

static bool has_term(const Term *const *list, const Term *term)
{
    for (int k = 0; k < PASS_TERMS_MAX && list[k]; k++)
        if (list[k] == term) return true;
    return false;
}

/* The terms of a pass that a fusion does, in their order. */
static Pass terms_of(const Pass *from, const Fusion *fusion)
{
    Pass pass = {.name = "one by one"};
    int n = 0;
    for (int k = 0; k < PASS_TERMS_MAX && from->terms[k]; k++)
        if (has_term(fusion->terms, from->terms[k]) || has_term(fusion->also, from->terms[k]))
            pass.terms[n++] = from->terms[k];
    return pass;
}

static void check(const Pass *from, const Fusion *fusion, const Mode *mode)
{
    const Fusion counting = watched(fusion, mode->dim, mode->marked, mode->level);
    const Pass apart = terms_of(from, fusion);
    Pass fused = apart;
    fused.fusions[0] = &counting;
    size_t n;
    double *a = result_of(&fused, mode, &n);
    assert_true(counted.calls > 0);
    double *b = result_of(&apart, mode, &n);
    double most = 0;
    for (size_t k = 0; k < ROWS * n; k++) {
        most = fabs(a[k]) > most ? fabs(a[k]) : most;
        if (!(a[k] == b[k]))
            fail_msg("%s: %.17g fused, %.17g one by one, row %zu of particle %zu", fusion->terms[0]->name, a[k], b[k],
                     k / n, k % n);
    }
    assert_true(most > 0);
    free(a);
    free(b);
}

/* Is it taken where a fluid that is spread is treated like this? */
static bool is_for(const Fusion *fusion, const Mode *mode)
{
    const Model model = {.reconstructs = mode->reconstructs,
                         .spared = mode->spared,
                         .transport_stress = mode->stressed,
                         .n_phases = 1,
                         .phase = {{.p_b = 1}}};
    for (int k = 0; k < PASS_TERMS_MAX && fusion->terms[k]; k++)
        if (!term_needed(fusion->terms[k], &model)) return false;
    return !fusion->needed || fusion->needed(&model);
}

static void check_all(const Pass *pass, const Fusion *fusion)
{
    static const MnsKernel kernels[] = {MNS_WENDLAND_C2, MNS_TRUNCATED_GAUSSIAN, MNS_QUINTIC_SPLINE};
    size_t checked = 0;
    for (size_t k = 0; k < 3; k++)
        for (int way = 0; way < 64; way++)
            for (int level = 0; level <= (int)level_in_use(); level++) {
                const Mode mode = {.dim = way & 1 ? 3 : 2,
                                   .kernel = kernels[k],
                                   .periodic = way & 2,
                                   .marked = way & 4,
                                   .stressed = way & 8,
                                   .reconstructs = way & 16,
                                   .spared = way < 48  ? SPARED_NOTHING
                                             : way & 8 ? SPARED_SLOPES
                                                       : SPARED_WEIGHT,
                                   .level = (Level)level};
                const bool spares = way >= 48 || way < 32; /* nothing twice */
                if (!spares || !is_for(fusion, &mode)) continue;
                check(pass, fusion, &mode);
                checked++;
            }
    assert_true(checked > 0);
}

static void fused_terms_have_the_bits_of_single_ones(void **state)
{
    (void)state;
    for (const Pass *pass = scheme_riemann.rates; pass->name; pass++)
        for (int f = 0; f < PASS_FUSIONS_MAX && pass->fusions[f]; f++) check_all(pass, pass->fusions[f]);
}

/* --- what is fused for some kinds of particles -------------------------------------------------------------------------- */

static int two_fluids(const double x[3])
{
    return x[0] < 0.75 ? CLOUD_WATER : CLOUD_AIR;
}

static int two_fluids_and_a_wall(const double x[3])
{
    return x[1] < 0.25 ? CLOUD_WALL : two_fluids(x);
}

/* How a cloud is made and its pass is run. */
typedef struct Way {
    int dim;
    MnsKernel kernel;
    bool periodic, walls, tense, marked, gas, own;
    Level level;
} Way;

static Cloud *mixed_cloud(const Way *way)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = way->dim,
                                           .dx = 0.1,
                                           .n = {16, 9, 8},
                                           .jitter = 0.3,
                                           .skin = 0.2,
                                           .periodic = {way->periodic, way->periodic, way->periodic},
                                           .kernel = way->kernel,
                                           .smoothing = 1,
                                           .viscous = true,
                                           .flowing = true,
                                           .owner = way->walls ? two_fluids_and_a_wall : two_fluids});
    Particles *s = &cloud->s;
    uint64_t seed = 21;
    cloud_stir(cloud, 8);
    cloud->model.level = way->level;
    cloud->model.density_average = 0.7;
    cloud->model.tense = way->tense;
    cloud->model.any_fills = cloud->model.phase[1].fills = way->gas;
    cloud->model.phase[1].resists = way->gas ? 0.375 : 0;
    cloud->model.own_gradients = way->own && (way->walls || way->tense) ? 1 : 0;
    cloud->model.viscous = !way->gas || way->tense; /* the others are for viscous fluids alone */
    for (size_t k = 0; k < 2; k++) cloud->model.phase[k].mu *= cloud->model.viscous ? 1 : 0;
    cloud->model.radial = true;
    cloud->model.wall[0].no_slip = true;
    const Pass first = {"marks", .terms = {&shepard_sum}};
    if (way->marked) pass_run(&first, s, &cloud->nb, &cloud->model, 1);
    for (size_t i = 0; i < s->n; i++) {
        s->shepard[i] = 1 + 0.4 * cloud_noise(&seed); /* some crowded */
        s->rate[i] = 0;
        s->curvature[i] = 5 * cloud_noise(&seed);
        for (int d = 0; d < way->dim; d++) {
            s->gradient[d][i] = 500 * cloud_noise(&seed);
            s->concentration[d][i] = 3 * cloud_noise(&seed);
            s->normal[d][i] = i % 3 == 0 || d > 1 ? 0 : d ? 0.6 : 0.8;
        }
    }
    for (size_t w = 0; w < s->n - particles_fluid(s); w++) {
        for (size_t a = 0; a < 2; a++) s->p_wall[a][w] = 100 * cloud_noise(&seed);
        for (int d = 0; d < way->dim; d++) s->v_wall[d][w] = cloud_noise(&seed);
    }
    change(cloud, way->marked);
    return cloud;
}

/* How many fluid particles have neighbours of these kinds and no others. */
static size_t of_kinds(const Cloud *cloud, unsigned kinds)
{
    size_t n = 0;
    for (size_t i = 0; i < particles_fluid(&cloud->s); i++) n += (cloud->nb.has[i] & LIST_KINDS) == kinds;
    return n;
}

static void assert_same(const Cloud *a, const Cloud *b, const char *name)
{
    const size_t n = a->s.n;
    assert_memory_equal(a->s.rate, b->s.rate, n * sizeof *a->s.rate);
    for (int f = 0; mns_fields()[f].name; f++)
        for (int d = 0; d < 3; d++) {
            const void *x = particles_field(&a->s, f, d), *y = particles_field(&b->s, f, d);
            const Owners owners = particles_owners(&a->s, f);
            if (x && memcmp(x, y, (owners.last - owners.first) * field_size(&mns_fields()[f])) != 0)
                fail_msg("%s: another %s when fused", name, mns_fields()[f].name);
        }
}

static void check_kinds(const Pass *from, const Fusion *fusion, const Way *way)
{
    Pass apart = terms_of(from, fusion), fused = apart;
    const Fusion counting = watched(fusion, way->dim, way->marked, way->level);
    Cloud *a = mixed_cloud(way), *b = mixed_cloud(way);
    size_t expected = 0;
    fused.fusions[0] = &counting;
    for (unsigned kinds = 0; kinds <= LIST_KINDS; kinds++) {
        if (way->walls || !(kinds & LIST_WALLS)) assert_true(of_kinds(a, kinds) > 0);
        if (fusion_serves(fusion, kinds) && counted.function && term_needed(fusion->terms[0], &a->model))
            expected += of_kinds(a, kinds);
    }
    pass_run(&fused, &a->s, &a->nb, &a->model, 1);
    pass_run(&apart, &b->s, &b->nb, &b->model, 1);
    assert_int_equal(counted.calls, expected);
    assert_same(a, b, from->name);
    cloud_free(a);
    cloud_free(b);
}

static void check_ways(const Pass *from, const Fusion *fusion)
{
    static const MnsKernel kernels[] = {MNS_WENDLAND_C2, MNS_TRUNCATED_GAUSSIAN, MNS_QUINTIC_SPLINE};
    for (size_t k = 0; k < 3; k++)
        for (unsigned bits = 0; bits < 32; bits++) {
            if (bits % 3 != k && !check_at_length()) continue;
            for (int level = 0; level <= (int)level_in_use(); level++) {
                const Model model = {.tense = bits & 8};
                if (fusion->needed && !fusion->needed(&model)) continue;
                const Way way = {.dim = bits & 1 ? 3 : 2,
                                 .kernel = kernels[k],
                                 .periodic = bits & 2,
                                 .walls = bits & 4,
                                 .tense = bits & 8,
                                 .marked = bits & 16,
                                 .gas = has_term(fusion->terms, &gas_dissipation),
                                 .own = has_term(fusion->terms, &pressure_gradient),
                                 .level = (Level)level};
                check_kinds(from, fusion, &way);
            }
        }
}

/* Of P1 and P2, in the order in which a pass looks for them. */
static void what_is_fused_for_some_particles_has_the_bits_of_rows(void **state)
{
    (void)state;
    static const Scheme *const schemes[] = {&scheme_dissipation, &scheme_interfacial};
    for (size_t k = 0; k < 2; k++)
        for (const Pass *pass = schemes[k]->rates; pass->name; pass++)
            for (int f = 0; f < PASS_FUSIONS_MAX && pass->fusions[f]; f++) check_ways(pass, pass->fusions[f]);
}

/* --- the three ways to a pair -------------------------------------------------------------------------------------------- */

/* Of all that is carried, but for the distance of what only fills up a block. */
static void assert_same_pair(Pair a, const Pair *b, bool beyond)
{
    if (beyond) a.r = b->r;
    const double *x = (const double *)&a, *y = (const double *)b;
    for (size_t k = 0; k < offsetof(Pair, other) / sizeof *x; k++)
        if (!(x[k] == y[k])) fail_msg("%g and %g at %zu of a pair", x[k], y[k], k);
}

/* Pairs of a row, those that were fetched, and those of blocks that were approached; returns whether any carries a normal. */
static bool compare_pairs(const RowPlan *plan, const Row *row, How how)
{
    uint32_t j[PICKED_MAX];
    double x[3];
    bool carries = false;
    Block block, rest, ahead[2];
    const Picked picked = pick_neighbours(plan, row->i, j);
    position_of(plan->s, row->i, how, x);
    approach(ahead, 0, plan, &picked, j, x, how);
    for (size_t b = 0; b < picked.n; b++) {
        const double *beyond = beyond_reach(plan, &picked, b);
        approach(ahead, b + 1, plan, &picked, j, x, how);
        fetch_block(&block, j + b * LANES, &plan->nb->bundles, plan->needs, how);
        fetch_rest(&rest, j + b * LANES, &plan->nb->bundles, plan->needs, how);
        for (int l = 0; l < LANES; l++) {
            const Pair laid = block_pair(&row->block[b], l, how),
                       fetched = fetched_pair(&block, l, beyond, x, plan, plan->needs, how),
                       near = near_pair(&ahead[b % 2], &rest, l, plan, plan->needs, how);
            assert_same_pair(fetched, &laid, beyond[l] > 0);
            assert_same_pair(near, &laid, beyond[l] > 0);
            carries |= fabs(near.normal[0]) > 0;
        }
    }
    return carries;
}

static void pairs_are_the_same_however_they_are_come_by(void **state)
{
    (void)state;
    static Row row;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(&(Mode){.dim = dim, .kernel = MNS_QUINTIC_SPLINE, .periodic = true});
        Particles *s = &cloud->s;
        uint64_t seed = 12;
        cloud->model.level = LEVEL_BASE;
        for (size_t i = 0; i < s->n; i++) s->shepard[i] = 1 + 0.1 * cloud_noise(&seed);
        for (int d = 0; d < dim; d++)
            for (size_t i = 0; i < s->n; i++) {
                s->gradient[d][i] = 500 * cloud_noise(&seed);
                s->normal[d][i] = cloud_noise(&seed);
            }
        particles_changed(s, ON_ALL, ALL_FIELDS);
        bool carries = false;
        neighbours_refresh(&cloud->nb, s, &cloud->model, NEED_ALL);
        const RowPlan plan = row_plan(&cloud->nb, s, &cloud->model, NEED_ALL, ROW_LISTED);
        const How how = {dim, BASE_FUSES, fetch_quads, true, kernel_shape_of(cloud->model.kernel.type)};
        for (size_t i = 0; i < particles_fluid(s); i++) {
            row_build(&row, &plan, i);
            carries |= compare_pairs(&plan, &row, how);
        }
        assert_true(carries);
        cloud_free(cloud);
    }
}

/* Places of what has changed are made again and no others: what follows a change of each field alone is what is made of all. */
static void bundles_are_what_fields_are_after_any_change(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int f = 0; f < FIELDS_END; f++) {
            Cloud *cloud = stirred(&(Mode){.dim = dim, .kernel = MNS_QUINTIC_SPLINE, .periodic = true});
            Particles *s = &cloud->s;
            uint64_t seed = 9;
            Bundles fresh;
            assert_true(bundles_init(&fresh, s->n, dim, NEED_ALL, 1));
            neighbours_refresh(&cloud->nb, s, &cloud->model, NEED_ALL);
            for (int d = 0; d < dim && mns_fields()[f].type == MNS_F64; d++) {
                double *array = particles_field(s, f, d);
                if (WALL_FIELDS >> f & 1) continue; /* of walls alone */
                for (size_t i = s->begin[1]; array && i < s->begin[2]; i++) array[i] = 1 + cloud_noise(&seed);
            }
            particles_changed(s, ON_SUMMATION, UINT64_C(1) << f);
            neighbours_refresh(&cloud->nb, s, &cloud->model, NEED_ALL);
            bundles_refresh(&fresh, s, &cloud->model, NEED_ALL, 1);
            for (int k = 0; k < (dim == 3 ? 4 : 3); k++)
                for (size_t i = 0; i < s->n; i++)
                    for (int c = 0; c < 4; c++)
                        if (!(fresh.data[k][i][c] == cloud->nb.bundles.data[k][i][c]))
                            fail_msg("%s: %g, not %g, at %d of bundle %d", mns_fields()[f].name,
                                     cloud->nb.bundles.data[k][i][c], fresh.data[k][i][c], c, k);
            bundles_done(&fresh);
            cloud_free(cloud);
        }
}

/* --- what is taken --------------------------------------------------------------------------------------------------- */

enum { OF_ONE, OF_TWO, OF_LIGHT, OF_GAS, MIXES };

/* A pass of a scheme, and what it takes for fluid that has neighbours of these kinds, by what there is and whether it is viscous. */
typedef struct Taken {
    const char *scheme, *pass;
    unsigned kinds;
    const Fusion *of[MIXES][2];
    const Fusion *stressed; /* of fluids without viscosity that feel where they are moved to; NULL: the same */
} Taken;

/* Whatever fluids there are. */
#define BY_VISCOSITY(plain, viscous)                                                                                   \
    {                                                                                                                  \
        {plain, viscous}, {plain, viscous}, {plain, viscous},                                                          \
        {                                                                                                              \
            plain, viscous                                                                                             \
        }                                                                                                              \
    }
/* light: where one is a gas, or a liquid that is lighter than the other. */
#define BESIDE_LIGHT(plain, viscous, light)                                                                            \
    {                                                                                                                  \
        {plain, viscous}, {plain, viscous}, {light, light},                                                            \
        {                                                                                                              \
            light, light                                                                                               \
        }                                                                                                              \
    }
#define ALWAYS(fusion) BY_VISCOSITY(fusion, fusion)

static const Taken TAKEN[] = {
    {"riemann", "density", 0, ALWAYS(&riemann_density_alone), NULL},
    {"riemann", "forces", 0, BY_VISCOSITY(&riemann_forces, NULL), &transported_forces},
    {"riemann", "forces", LIST_WALLS | LIST_OTHERS, BY_VISCOSITY(&riemann_forces, NULL), &transported_forces},
    {"dissipation", "rates", 0, BESIDE_LIGHT(&dissipation_rates, &dissipation_viscous_rates, &dissipation_gas_rates),
     NULL},
    {"dissipation", "rates", LIST_OTHERS, BESIDE_LIGHT(NULL, &dissipation_rates_beside, &dissipation_gas_rates_beside),
     NULL},
    {"interfacial", "forces", 0, BY_VISCOSITY(&interfacial_forces, &interfacial_viscous_forces), NULL},
    {"interfacial", "forces", LIST_OTHERS, BY_VISCOSITY(NULL, &interfacial_forces_beside), NULL},
    {"incompressible", "number density", 0, ALWAYS(&number_density_alone), NULL},
    {"incompressible", "number density", LIST_WALLS | LIST_OTHERS, ALWAYS(&number_density_alone), NULL},
    {"incompressible", "forces", 0, ALWAYS(NULL), NULL},
};

static MnsCase *case_of(const char *scheme, int mix, bool viscous, bool stressed)
{
    MnsCase *c = case_periodic(2, 12);
    c->scheme.name = scheme;
    c->scheme.riemann.transport_stress = stressed;
    c->scheme.riemann.reconstruction = MNS_RECONSTRUCTION_NONE;
    c->scheme.dissipation.pair_average = MNS_AVERAGE_DENSITY;
    if (strcmp(scheme, "incompressible") == 0) {
        c->scheme.kernel = MNS_QUINTIC_SPLINE;
        c->scheme.smoothing = 1;
    }
    for (size_t k = 0; k < c->n_fluids; k++) {
        c->fluids[k].viscosity = viscous ? 0.01 : 0;
        c->fluids[k].density = mix <= OF_TWO || k == 0 ? 1 : mix == OF_LIGHT ? 0.5 : 0.01;
        c->fluids[k].density_method = MNS_DENSITY_AUTOMATIC;
    }
    return c;
}

static const Pass *pass_of(const Scheme *scheme, const char *name)
{
    for (const Pass *pass = scheme->rates; pass->name; pass++)
        if (strcmp(pass->name, name) == 0) return pass;
    fail_msg("%s has no %s", scheme->name, name);
    return NULL;
}

/* With a transport stress and without. */
static void schemes_take_what_is_fused_for_their_fluids(void **state)
{
    (void)state;
    if (level_in_use() == LEVEL_BASE) skip(); /* not all is fused there */
    for (size_t k = 0; k < sizeof TAKEN / sizeof *TAKEN; k++)
        for (int way = 0; way < 4 * MIXES; way++) {
            const bool viscous = way & 1;
            MnsCase *c = case_of(TAKEN[k].scheme, way / 4, viscous, way & 2);
            MnsSim *sim = sim_of(c);
            const Pass *pass = pass_of(sim->scheme, TAKEN[k].pass);
            const int group = sim->s.begin[1] > 0 ? GROUP_CONTINUITY : GROUP_SUMMATION;
            const Fusion *taken = pass_fusion(pass, group, TAKEN[k].kinds, &sim->model);
            const bool stressed = way & 2 && !viscous && TAKEN[k].stressed;
            if (taken != (stressed ? TAKEN[k].stressed : TAKEN[k].of[way / 4][viscous]))
                fail_msg("%s of %s, kinds %u, way %d: another way", pass->name, TAKEN[k].scheme, TAKEN[k].kinds, way);
            sim_done(sim, c);
        }
}

/* --- marks ------------------------------------------------------------------------------------------------------------ */

/* Marks that a pass leaves are those of a sum over all that are listed, or are not used: nobody was in reach when it began. */
static void check_marks(Cloud *cloud, const Pass *pass)
{
    Particles *s = &cloud->s;
    Neighbours *nb = &cloud->nb;
    const Pass next = {"next", .terms = {&shepard_sum}};
    for (size_t i = 0; i < s->n; i++) {
        const size_t fluid = nb->end[i][END_FLUID], walls = nb->end[i][END_WALLS] - fluid;
        memset(neighbours_marks(nb, i), 0, neighbours_mark_bytes(fluid) + neighbours_mark_bytes(walls));
    }
    change(cloud, false);
    pass_run(pass, s, nb, &cloud->model, 1);
    pass_run(&next, s, nb, &cloud->model, 1);
    double *trusted = calloc(s->n, sizeof *trusted);
    assert_non_null(trusted);
    memcpy(trusted, s->shepard, s->n * sizeof *trusted);
    change(cloud, false);
    pass_run(&next, s, nb, &cloud->model, 1);
    for (size_t i = 0; i < particles_fluid(s); i++)
        if (!(fabs(trusted[i] - s->shepard[i]) <= 1e-12 * s->shepard[i]))
            fail_msg("after %s of %s: sum %.17g of marked pairs, %.17g of all", pass->terms[0]->name, pass->name,
                     trusted[i], s->shepard[i]);
    free(trusted);
}

static void marks_are_used_only_where_they_were_noted(void **state)
{
    (void)state;
    static const Scheme *const schemes[] = {&scheme_riemann, &scheme_dissipation, &scheme_interfacial};
    for (size_t k = 0; k < 3; k++)
        for (const Pass *pass = schemes[k]->rates; pass->name; pass++)
            for (int f = 0; f < PASS_FUSIONS_MAX && pass->fusions[f]; f++)
                for (int way = 0; way < 4; way++)
                    for (int level = 0; level <= (int)level_in_use(); level++) {
                        Mode mode = {.dim = way & 1 ? 3 : 2, .periodic = way & 2};
                        for (int q = 0; q < 16 && !k && !is_for(pass->fusions[f], &mode); q++) {
                            mode.spared = (Spared)(q % 4 % 3);
                            mode.stressed = q & 4;
                            mode.reconstructs = q & 8;
                        }
                        const Way of = {.dim = way & 1 ? 3 : 2, .walls = way & 2, .tense = true, .level = (Level)level};
                        Cloud *cloud = k ? mixed_cloud(&of) : stirred(&mode);
                        cloud->model.transport_stress = mode.stressed;
                        Pass fused = terms_of(pass, pass->fusions[f]);
                        fused.name = pass->name;
                        fused.fusions[0] = pass->fusions[f];
                        cloud->model.level = (Level)level;
                        check_marks(cloud, &fused);
                        cloud_free(cloud);
                    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fused_terms_have_the_bits_of_single_ones),
        cmocka_unit_test(what_is_fused_for_some_particles_has_the_bits_of_rows),
        cmocka_unit_test(pairs_are_the_same_however_they_are_come_by),
        cmocka_unit_test(bundles_are_what_fields_are_after_any_change),
        cmocka_unit_test(schemes_take_what_is_fused_for_their_fluids),
        cmocka_unit_test(marks_are_used_only_where_they_were_noted),
    };
    return cmocka_run_group_tests_name("fused", tests, NULL, NULL);
}
