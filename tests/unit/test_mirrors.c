/* SPDX-License-Identifier: BSD-3-Clause */
/* Mirrors are planes of symmetry: all terms of the schemes that have them find beside one what they find in the whole of which it cuts half
 * off, in corners and beside other walls too. Systems stay symmetric to the last bit, and a fluid at rest over a mirror has the pressure of
 * its depth. */
#include "sim/locals/locals.h"
#include "sim/mirrors.h"
#include "sim/terms/differences.h"
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"

static const double DX = 0.1;
enum { WIDE = 7, HIGH = 8, DEEP = 9, BEHIND = 4 }; /* points before the mirrors, and in the walls behind them */
enum { NARROW = 4 };                               /* between two mirrors, both in reach of what is midway */

/* Folded back at the planes x = WIDE dx and y = HIGH dx, if there is one: over a floor, a drop of air in the corner. Between two mirrors, x = 0 is one
 * and x = NARROW dx the other, and the whole is a period. */
static bool in_corner, in_half, in_channel;

static int before(void)
{
    return in_channel ? NARROW : WIDE;
}

static double folded(double x, int points)
{
    return x < points * DX ? x : 2 * points * DX - x;
}

static int half_or_whole(const double x[3])
{
    const double X = before() * DX, Y = HIGH * DX;
    if (in_half && (x[0] > X || (in_corner && x[1] > Y))) return CLOUD_WALL;
    const double a = folded(x[0], before()), b = in_corner ? folded(x[1], HIGH) : x[1];
    if (b < 0.3) return CLOUD_WALL;
    return hypot(hypot(a - X, b - Y), x[2] - 0.4) < 0.42 ? CLOUD_AIR : CLOUD_WATER;
}

static size_t wide(bool half)
{
    const int behind = in_channel ? 0 : BEHIND;
    return (size_t)(half ? before() + behind : 2 * before());
}

static size_t high(bool half, bool corner)
{
    return half || !corner ? HIGH + BEHIND : 2 * HIGH;
}

static Cloud *lay(int dim, bool half, bool corner, double smoothing, double skin)
{
    in_corner = corner;
    in_half = half;
    return cloud_new(&(CloudSetup){.dim = dim,
                                   .dx = DX,
                                   .n = {wide(half), high(half, corner), DEEP},
                                   .skin = skin,
                                   .smoothing = smoothing,
                                   .kernel = MNS_QUINTIC_SPLINE,
                                   .periodic = {in_channel && !half, false, true},
                                   .viscous = true,
                                   .calibrated = true,
                                   .owner = half_or_whole});
}

/* The point of the lattice that a particle began at. */
typedef struct Point {
    size_t of[3];
} Point;

static Point point_of(const Cloud *cloud, size_t i, bool half, bool corner)
{
    const size_t id = cloud->s.id[i], a = wide(half), b = high(half, corner);
    return (Point){{id % a, id / a % b, id / a / b}};
}

/* The particle of the whole that is that of the half, or its image. */
static size_t in_whole(const Cloud *whole, Point p, bool corner)
{
    return cloud_index(whole, (uint32_t)(p.of[0] + wide(false) * (p.of[1] + high(false, corner) * p.of[2])));
}

/* Everything that a particle may start with, without symmetry in the half; as a mirror has it in the other. */
static void set_fields(Cloud *cloud, bool half, bool corner)
{
    Particles *s = &cloud->s;
    for (size_t i = 0; i < s->n; i++) {
        Point p = point_of(cloud, i, half, corner);
        const bool turned[3] = {!half && 2 * p.of[0] >= wide(false), !half && corner && p.of[1] >= HIGH, false};
        if (turned[0]) p.of[0] = wide(false) - 1 - p.of[0];
        if (turned[1]) p.of[1] = 2 * HIGH - 1 - p.of[1];
        uint64_t seed = 1 + p.of[0] + 100 * p.of[1] + 10000 * p.of[2];
        const double size[3] = {2 * before() * DX, 2 * HIGH * DX, 0};
        for (int d = 0; d < s->dim; d++) {
            const double x = ((double)p.of[d] + 0.5 + 0.2 * cloud_noise(&seed)) * DX, v = cloud_noise(&seed);
            s->x[d][i] = turned[d] ? size[d] - x : x;
            s->v[d][i] = turned[d] ? -v : v;
        }
        s->m[i] *= 1 + 0.1 * cloud_noise(&seed);
        s->p[i] = 100 * cloud_noise(&seed);
        for (int d = 0; d < s->dim; d++) {
            const double b = 100 * cloud_noise(&seed);
            s->b[d][i] = turned[d] ? -b : b;
        }
    }
}

/* Two clouds that hold the same: all of it, and half or a quarter before mirrors. */
typedef struct Both {
    Cloud *whole, *part;
    bool corner;
} Both;

static Both both_of(int dim, bool corner, double smoothing, double skin)
{
    Both both = {lay(dim, false, corner, smoothing, skin), lay(dim, true, corner, smoothing, skin), corner};
    for (int k = 0; k < 2; k++) {
        Cloud *cloud = k ? both.part : both.whole;
        Model *model = &cloud->model;
        cloud->model.wall[0].no_slip = true;
        model->projection.unit_mobility = false;
        cloud_weigh(cloud, 1, 200);
        model->gravity[2] = dim == 3 ? -9.81 : 0;
        if (!corner) model->gravity[1] = -9.81;
        if (k) {
            model->mirror_at[1] = before() * DX; /* the domain reaches farther */
            model->mirrors = in_channel ? 3 : 2;
            if (corner) model->mirror_at[3] = HIGH * DX;
            model->min[0] -= in_channel ? BEHIND * DX : 0;
            if (corner) model->mirrors |= 8;
        }
        set_fields(cloud, k, corner);
        assert_int_equal(cloud_build(cloud), MNS_OK);
        cloud_term(cloud, &wall_density);
        cloud_term(cloud, &mixture);
        for (size_t i = 0; i < cloud->s.n; i++) {
            Point p = point_of(cloud, i, k, corner);
            if (!k && 2 * p.of[0] >= wide(false)) p.of[0] = wide(false) - 1 - p.of[0];
            if (!k && corner && p.of[1] >= HIGH) p.of[1] = 2 * HIGH - 1 - p.of[1];
            uint64_t seed = 7 + p.of[0] + 100 * p.of[1] + 10000 * p.of[2];
            cloud->system.x[i] = cloud_noise(&seed);
        }
    }
    return both;
}

static void both_done(Both *both)
{
    cloud_free(both->whole);
    cloud_free(both->part);
}

/* What terms write. */
enum { RESULTS = 19, FLOATS = 11 }; /* right-hand sides at walls are of entries, which are floats */
static double *const *result(Cloud *cloud, int k, int *ret_components, bool *ret_walls)
{
    Particles *s = &cloud->s;
    static double *one[1];
    static const struct {
        int components; /* 0: as many as dimensions */
        bool walls;
    } table[RESULTS] = {{0, false}, {0, false}, {0, false}, {1, false}, {0, false}, {0, false}, {0, false},
                        {0, false}, {1, false}, {1, true},  {1, true},  {1, true},  {1, true},  {0, false},
                        {0, false}, {0, false}, {0, false}, {1, false}, {1, true}};
    *ret_components = table[k].components ? table[k].components : s->dim;
    if (k == 16 && s->dim == 2) *ret_components = 1;
    *ret_walls = table[k].walls;
    switch (k) {
    case 0: return s->a;
    case 1: return s->v;
    case 2: return s->x;
    case 3: one[0] = s->curvature; return one;
    case 4: return s->normal;
    case 5: return s->colour_gradient;
    case 6: return s->correction;
    case 7: return s->offset;
    case 8: one[0] = s->laplacian; return one;
    case 9: one[0] = s->colour; return one;
    case 10: one[0] = s->rho; return one;
    case 11: one[0] = cloud->system.b; return one;
    case 12: one[0] = s->rate; return one;
    case 13: return s->gradient;
    case 14: return s->concentration;
    case 15: return s->b;
    case 16: return s->correction_off;
    case 17: one[0] = s->shepard; return one;
    default: one[0] = s->p; return one;
    }
}

static double largest(Cloud *cloud, int k)
{
    double most = 0;
    int n;
    bool walls;
    double *const *of = result(cloud, k, &n, &walls);
    for (int d = 0; d < n; d++)
        for (size_t i = 0; i < (walls ? cloud->s.n : particles_fluid(&cloud->s)); i++)
            most = fmax(most, fabs(of[d][i]));
    return most;
}

static void assert_same_results(Both *both, const char *what, double rounding)
{
    Cloud *part = both->part, *whole = both->whole;
    for (int k = 0; k < RESULTS; k++) {
        const double most = largest(whole, k), allowed = (k == FLOATS ? fmax(rounding, 1e-5) : rounding) * most;
        int n;
        bool walls;
        for (size_t i = 0; i < part->s.n; i++) {
            if (mirrors_hide(&part->model, &part->s, i)) continue;
            const size_t j = in_whole(whole, point_of(part, i, true, both->corner), both->corner);
            (void)result(part, k, &n, &walls);
            for (int d = 0; d < n && (walls || i < particles_fluid(&part->s)); d++) {
                const double here = result(part, k, &n, &walls)[d][i], there = result(whole, k, &n, &walls)[d][j];
                if (!(fabs(here - there) <= allowed))
                    fail_msg("%s: result %d has component %d %.17g in the half, %.17g in the whole, of %.3g at most",
                             what, k, d, here, there, most);
            }
        }
    }
}

static void assert_same_velocities_in_walls(Both *both, const char *what)
{
    const Particles *s = &both->part->s, *t = &both->whole->s;
    size_t walls = 0;
    for (size_t i = particles_fluid(s); i < s->n; i++) {
        if (mirrors_hide(&both->part->model, s, i)) continue;
        const size_t j = in_whole(both->whole, point_of(both->part, i, true, both->corner), both->corner);
        for (int d = 0; d < s->dim; d++) {
            const double here = s->v_wall[d][i - particles_fluid(s)], there = t->v_wall[d][j - particles_fluid(t)];
            if (!(fabs(here - there) < 1e-10)) fail_msg("%s: %.17g and %.17g in a wall", what, here, there);
        }
        walls++;
    }
    assert_true(walls > 10);
}

/* Is it a mean of what the term before has found? */
static bool is_mean(const Term *term)
{
    const Term *const terms[] = {&mean_curvature, &next_mean, &sharp_curvature, &sharp_mean, &mean_colour_curvature};
    for (size_t k = 0; k < sizeof terms / sizeof *terms; k++)
        if (term == terms[k]) return true;
    return false;
}

/* Run a term in both. */
static void check(Both *both, const Term *term, double rounding)
{
    cloud_term(both->whole, term);
    cloud_term(both->part, term);
    /* means of few are of weights near 0 */
    assert_same_results(both, term->name, is_mean(term) ? fmax(rounding, 1e-8) : rounding);
}

/* And what the matrix makes of the pressure, where entries are floats. */
static void check_matrix(Both *both, const Term *fluid, const Term *walls)
{
    double most = 0;
    check(both, fluid, 1e-5);
    cloud_term(both->whole, walls);
    cloud_term(both->part, walls);
    for (int k = 0; k < 2; k++) {
        System *y = k ? &both->part->system : &both->whole->system;
        matrix_multiply(&y->matrix, y->x, y->work[0], 1);
    }
    const Particles *s = &both->part->s;
    System *y = &both->part->system, *z = &both->whole->system;
    for (size_t i = 0; i < z->matrix.n; i++) most = fmax(most, fabs(z->work[0][i]));
    for (size_t i = 0; i < s->n; i++) {
        const size_t j = in_whole(both->whole, point_of(both->part, i, true, both->corner), both->corner);
        if (mirrors_hide(&both->part->model, s, i)) {
            assert_int_equal(y->matrix.blocks[i], 0);
            continue;
        }
        assert_close(y->work[0][i], z->work[0][j], 1e-6 * most);
        assert_close(y->b[i], z->b[j], 1e-6 * (1 + fabs(z->b[j])));
    }
}

/* Accelerations along x, yours. */
static double *accelerations(Cloud *cloud)
{
    double *a = calloc(cloud->s.n, sizeof *a);
    assert_non_null(a);
    cloud_term(cloud, &viscosity);
    for (size_t i = 0; i < cloud->s.n; i++) a[cloud->s.id[i] % cloud->s.n] = cloud->s.a[0][i];
    return a;
}

/* Without mirrors, particles beside them find something else. */
static void assert_mirrors_matter(Both *both)
{
    Cloud *part = both->part;
    const unsigned mirrors = part->model.mirrors;
    size_t others = 0;
    double *with = accelerations(part);
    part->model.mirrors = 0;
    assert_int_equal(cloud_build(part), MNS_OK);
    double *without = accelerations(part);
    for (size_t i = 0; i < part->s.n; i++) others += fabs(with[i] - without[i]) > 1e-6 * fabs(with[i]);
    assert_true(others > 8 && others < particles_fluid(&part->s));
    part->model.mirrors = mirrors;
    assert_int_equal(cloud_build(part), MNS_OK);
    free(with);
    free(without);
}

static void terms_of_incompressible_find_half_of_the_whole(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int corner = 0; corner < 2; corner++) {
            Both both = both_of(dim, corner, 1, 0.3);
            assert_mirrors_matter(&both);
            check(&both, &number_density, 1e-12);
            check(&both, &wall_density, 1e-12);
            check_matrix(&both, &density_matrix, &density_wall_matrix);
            check(&both, &mirrored_start, 1e-12);
            assert_same_velocities_in_walls(&both, "mirrored start");
            check_matrix(&both, &velocity_matrix, &velocity_wall_matrix);
            check(&both, &velocity_divergence, 1e-10);
            check(&both, &velocity_correction, 1e-10);
            check(&both, &wall_velocity, 1e-12);
            assert_same_velocities_in_walls(&both, "wall velocity");
            check(&both, &corrected_normal, 1e-10);
            check(&both, &raw_curvature_first, 1e-9);
            check(&both, &next_mean, 1e-9);
            check(&both, &sharp_mean, 1e-9);
            check(&both, &viscosity, 1e-10);
            check(&both, &transposed_viscosity, 1e-10);
            check(&both, &wall_friction, 1e-10);
            check(&both, &density_correction, 1e-10);
            both_done(&both);
        }
}

static void terms_of_differences_find_half_of_the_whole(void **state)
{
    (void)state;
    static const Term *const rates[] = {&harmonic_diffusion, &divtau_diffusion, &conservative_diffusion,
                                        &sph_diffusion};
    static const MnsDiffusion diffusions[] = {MNS_DIFFUSION_HARMONIC, MNS_DIFFUSION_DIVTAU, MNS_DIFFUSION_CONSERVATIVE,
                                              MNS_DIFFUSION_SPH};
    for (int dim = 2; dim <= 3; dim++)
        for (int corner = 0; corner < 2; corner++) {
            Both both = both_of(dim, corner, 0.9, 0.3);
            check(&both, &truncation, 1e-10);
            check(&both, &mixture, 1e-12);
            check(&both, &continued_start, 1e-12);
            assert_same_velocities_in_walls(&both, "continued start");
            check_matrix(&both, &difference_matrix, &difference_wall_matrix);
            check(&both, &difference_correction, 1e-10);
            check(&both, &continued_velocity, 1e-12);
            assert_same_velocities_in_walls(&both, "continued velocity");
            check(&both, &colour_gradient, 1e-10);
            check(&both, &colour_curvature, 1e-9);
            check(&both, &mean_colour_curvature, 1e-9);
            for (int k = 0; k < 4; k++) {
                both.whole->model.differences.diffusion = both.part->model.differences.diffusion = diffusions[k];
                check(&both, rates[k], 1e-9);
            }
            check(&both, &even_spacing, 1e-9);
            both_done(&both);
        }
}

static void assert_same_pressures_in_walls(Both *both)
{
    const Particles *s = &both->part->s, *t = &both->whole->s;
    size_t walls = 0;
    for (size_t i = particles_fluid(s); i < s->n; i++) {
        if (mirrors_hide(&both->part->model, s, i)) continue;
        const size_t j = in_whole(both->whole, point_of(both->part, i, true, both->corner), both->corner);
        for (int a = 0; a < 2; a++)
            assert_close(s->p_wall[a][i - particles_fluid(s)], t->p_wall[a][j - particles_fluid(t)], 1e-9);
        walls++;
    }
    assert_true(walls > 10);
}

/* What the schemes with sound have of a mirror: one is a flat face of a wall too, which interfaces must not see twice. */
static void add_faces(Both *both)
{
    static Face of_part[3] = {
        {{0, 0.3, 0}, {0, 1, 0}, 0}, {{WIDE * 0.1, 0, 0}, {-1, 0, 0}, 0}, {{0, HIGH * 0.1, 0}, {0, -1, 0}, 0}};
    static Face of_whole[2] = {{{0, 0.3, 0}, {0, 1, 0}, 0}, {{0, 2 * HIGH * 0.1 - 0.3, 0}, {0, -1, 0}, 0}};
    both->part->model.face = of_part;
    both->whole->model.face = of_whole;
    both->whole->model.n_faces = both->corner ? 2 : 1;
    both->part->model.n_faces = both->corner ? 3 : 2;
    for (int k = 0; k < 2; k++) {
        Model *model = &(k ? both->part : both->whole)->model;
        model->lag = 0.5 * model->dt;
        model->any_fills = model->phase[1].fills = true;
        model->phase[1].resists = 1;
        model->filled = true;
    }
}

static void terms_with_sound_find_half_of_the_whole(void **state)
{
    (void)state;
    static const Term *const terms[] = {
        &shepard_sum,         &concentration,   &pressure_gradient,     &continuity,      &volume_continuity,
        &density_dissipation, &pressure_force,  &volume_pressure_force, &gas_dissipation, &viscosity,
        &radial_viscosity,    &wall_friction,   &interface_normal,      &raw_curvature,   &mean_curvature,
        &next_mean,           &sharp_curvature, &corrected_normal,      &number_density,  &riemann_density,
        &riemann_momentum,    &background,      &transport_stress};
    for (int dim = 2; dim <= 3; dim++)
        for (int corner = 0; corner < 2; corner++) {
            Both both = both_of(dim, corner, 1, 0);
            add_faces(&both);
            check(&both, &wall_pressure, 1e-10);
            assert_same_pressures_in_walls(&both);
            check(&both, &wall_velocity, 1e-12);
            assert_same_velocities_in_walls(&both, "wall velocity");
            for (size_t k = 0; k < sizeof terms / sizeof *terms; k++) check(&both, terms[k], 1e-9);
            both.whole->model.spared = both.part->model.spared = SPARED_SLOPES;
            check(&both, &pressure_slope, 1e-9);
            check(&both, &riemann_density, 1e-9);
            both.whole->model.spared = both.part->model.spared = SPARED_WEIGHT;
            check(&both, &riemann_density, 1e-9);
            check(&both, &mirrored_velocity, 1e-12);
            assert_same_velocities_in_walls(&both, "mirrored velocity");
            check(&both, &radial_friction, 1e-10);
            both.whole->model.corrects_gradients = both.part->model.corrects_gradients = true;
            check(&both, &corrected_continuity, 1e-9);
            check(&both, &corrected_pressure_force, 1e-9);
            check(&both, &shifting, 1e-10);
            both_done(&both);
        }
}

/* Particles midway have images by either mirror, and none by both. */
static void terms_between_two_mirrors_find_half_of_a_period(void **state)
{
    (void)state;
    in_channel = true;
    for (int dim = 2; dim <= 3; dim++) {
        Both both = both_of(dim, false, 1, 0.3);
        check(&both, &number_density, 1e-12);
        check(&both, &shepard_sum, 1e-12);
        check_matrix(&both, &velocity_matrix, &velocity_wall_matrix);
        check(&both, &pressure_gradient, 1e-9);
        check(&both, &viscosity, 1e-10);
        check(&both, &wall_velocity, 1e-12);
        assert_same_velocities_in_walls(&both, "wall velocity");
        both_done(&both);
    }
    in_channel = false;
}

/* --- systems -------------------------------------------------------------------------------------------------------------- */

static double entry(const Matrix *m, size_t row, size_t column)
{
    double sum = 0;
    for (size_t k = m->start[row] * ENTRIES; k < (m->start[row] + m->blocks[row]) * ENTRIES; k++)
        if (m->column[k] == column) sum += (double)m->c[k];
    return sum;
}

static void systems_beside_mirrors_are_symmetric_to_the_last_bit(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Both both = both_of(dim, true, 1, 0.3);
        const Particles *s = &both.part->s;
        const Matrix *m = &both.part->system.matrix;
        cloud_term(both.part, &velocity_matrix);
        cloud_term(both.part, &velocity_wall_matrix);
        size_t pairs = 0;
        for (size_t i = 0; i < s->n; i++) {
            assert_true(entry(m, i, i) == 0);
            for (size_t j = 0; j < i; j++) {
                assert_true(entry(m, i, j) == entry(m, j, i));
                pairs += entry(m, i, j) > 0;
            }
        }
        assert_true(pairs > 100);
        both_done(&both);
    }
}

static int over_nothing(const double x[3])
{
    (void)x;
    return CLOUD_WATER;
}

static int beside_a_wall(const double x[3])
{
    return x[0] < 0.3 ? CLOUD_WALL : CLOUD_WATER;
}

/* On a lattice, in a corner of mirrors, under a gravity across all of them: the pressure of the depth solves the system to the digits of floats, and takes
 * away what gravity gives; beside a wall that is no mirror, too. */
static void a_fluid_at_rest_in_a_corner_of_mirrors_has_the_pressure_of_its_depth(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int way = 0; way < 4; way++) {
            const bool scheme = way & 1, walled = way & 2;
            Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                                   .dx = DX,
                                                   .n = {10, 9, 8},
                                                   .smoothing = 1,
                                                   .kernel = MNS_QUINTIC_SPLINE,
                                                   .calibrated = true,
                                                   .viscous = true,
                                                   .owner = walled ? beside_a_wall : over_nothing});
            Particles *s = &cloud->s;
            System *y = &cloud->system;
            Model *model = &cloud->model;
            const double g[3] = {3, -9.81, 2}, dt = model->dt;
            model->mirrors = (dim == 2 ? 15u : 63u) & ~(walled ? 1u : 0u);
            model->wall[0].no_slip = true;
            for (int d = 0; d < dim; d++) model->gravity[d] = g[d];
            assert_int_equal(cloud_build(cloud), MNS_OK);
            for (size_t i = 0; i < s->n; i++) {
                y->x[i] = 5;
                for (int d = 0; d < dim; d++) y->x[i] += dt * 1000 * g[d] * s->x[d][i];
                for (int d = 0; d < dim; d++) s->v[d][i] = scheme && i < particles_fluid(s) ? dt * g[d] : 0;
            }
            if (scheme) {
                cloud_term(cloud, &truncation);
                cloud_term(cloud, &mixture);
                cloud_term(cloud, &continued_start);
                cloud_term(cloud, &difference_matrix);
                cloud_term(cloud, &difference_wall_matrix);
            } else {
                cloud_term(cloud, &wall_density);
                cloud_term(cloud, &mirrored_start);
                cloud_term(cloud, &velocity_matrix);
                cloud_term(cloud, &velocity_wall_matrix);
                cloud_term(cloud, &velocity_divergence);
            }
            matrix_multiply(&y->matrix, y->x, y->work[0], 1);
            for (size_t i = 0; i < s->n; i++)
                assert_close(y->work[0][i], y->b[i], 1e-6 * y->matrix.diagonal[i] * dt * 1000 * 10 * DX);
            if (scheme) {
                cloud_term(cloud, &difference_correction);
                local_run(&corrected_velocity, s, model, 1);
            } else cloud_term(cloud, &velocity_correction);
            for (size_t i = 0; i < particles_fluid(s); i++)
                for (int d = 0; d < dim; d++) assert_close(s->v[d][i], scheme ? 0 : -dt * g[d], 1e-12);
            cloud_free(cloud);
        }
}

static void more_images_than_a_row_has_room_for_are_refused(void **state)
{
    (void)state;
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = 2, .dx = DX, .n = {30, 20}, .smoothing = 1, .owner = over_nothing});
    Particles *s = &cloud->s;
    for (size_t i = 0; i < s->n; i++) {
        s->x[0][i] = 0.05 + 1e-4 * (double)(s->id[i] % 30);
        s->x[1][i] = 1 + 1e-4 * (double)(s->id[i] / 30);
    }
    assert_int_equal(cloud_build(cloud), MNS_OK);
    cloud->model.mirrors = 1;
    assert_int_equal(cloud_build(cloud), MNS_E_LIMIT);
    cloud_free(cloud);
}

/* Walls of (0.05, 0.15, 0.25) m, and the mirror somewhere among them: what is up to half a skin behind it may be before it when lists are
 * built again. */
static void walls_that_may_come_from_behind_a_mirror_stay_in_lists(void **state)
{
    (void)state;
    static const struct {
        double side;
        size_t columns;
    } rows[] = {{0.01, 3}, {0.24, 1}, {0.26, 1}, {0.27, 0}};
    Cloud *cloud = cloud_new(&(CloudSetup){
        .dim = 2, .dx = DX, .n = {10, 9}, .smoothing = 1, .skin = 0.3, .calibrated = true, .owner = beside_a_wall});
    const Particles *s = &cloud->s;
    const size_t fluid = particles_fluid(s), walls = s->n - fluid;
    assert_int_equal(walls, 27);
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++)
        for (int mirrored = 0; mirrored < 2; mirrored++) {
            uint32_t list[27];
            size_t kept = 0;
            for (size_t q = 0; q < walls; q++) list[q] = (uint32_t)(fluid + q);
            cloud->model.mirror_at[0] = rows[k].side;
            cloud->model.mirrors = mirrored ? 1 : 0;
            const size_t n = mirrors_thin(&cloud->model, s, list, walls);
            assert_int_equal(n, mirrored ? 9 * rows[k].columns : walls);
            for (size_t i = fluid; i < s->n; i++) {
                if (mirrored && s->ref[0][i] < 0.3 - 0.1 * (double)rows[k].columns) continue;
                assert_int_equal(list[kept++], i);
            }
            assert_int_equal(kept, n);
        }
    cloud_free(cloud);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(terms_of_incompressible_find_half_of_the_whole),
        cmocka_unit_test(terms_of_differences_find_half_of_the_whole),
        cmocka_unit_test(terms_with_sound_find_half_of_the_whole),
        cmocka_unit_test(terms_between_two_mirrors_find_half_of_a_period),
        cmocka_unit_test(systems_beside_mirrors_are_symmetric_to_the_last_bit),
        cmocka_unit_test(a_fluid_at_rest_in_a_corner_of_mirrors_has_the_pressure_of_its_depth),
        cmocka_unit_test(more_images_than_a_row_has_room_for_are_refused),
        cmocka_unit_test(walls_that_may_come_from_behind_a_mirror_stay_in_lists),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
