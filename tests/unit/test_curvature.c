/* SPDX-License-Identifier: BSD-3-Clause */
/* Normals of interfaces are those of P1 and P2, and curvatures the divergence of these and means of it, among any number of fluids: nothing at flat
 * interfaces, those of circles and balls to second order, and beside flat walls those of the whole of which they show a part. What the pressure of a
 * neighbour lacks is opposite for the two of a pair, all of sigma times the curvature, and balances a drop at rest. */
#include "sim/terms/curvature.h"
#include "sim/terms/jump.h"
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <stdlib.h>
#include <string.h>

/* How schemes find curvatures. */
typedef struct Form {
    const Term *normal, *curvature[4];
    bool corrected, state; /* normals; are pressures those of a state? */
} Form;

enum { FORMS = 3 };
static const Form FORM[FORMS] = {
    {&interface_normal, {&raw_curvature, &mean_curvature, &next_mean, &sharp_curvature}, false, true},
    {&corrected_normal, {&raw_curvature, &mean_curvature, &next_mean, &sharp_curvature}, true, true},
    {&corrected_normal, {&raw_curvature_first, &next_mean, &sharp_mean}, true, false}};

static const double SIGMA = 0.7; /* of water and air (cloud.h) */

static void find_curvature(Cloud *cloud, const Form *form)
{
    cloud_term(cloud, form->normal);
    for (int k = 0; k < 4 && form->curvature[k]; k++) cloud_term(cloud, form->curvature[k]);
}

static int tank(const double x[3])
{
    if (x[1] < 0.3) return CLOUD_WALL;
    if (x[1] > 0.95 - 0.3 * (x[0] - 0.5) * (x[0] - 0.5)) return CLOUD_NOTHING;
    return x[1] < 0.5 + 0.3 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

static bool in_reach(const Cloud *cloud, size_t i, size_t j)
{
    return j != i && cloud_pair(cloud, i, j).r < cloud->model.kernel.support;
}

static bool particle_has_normal(const Particles *s, size_t i)
{
    double n2 = 0;
    for (int d = 0; d < s->dim; d++) n2 += s->normal[d][i] * s->normal[d][i];
    return n2 > 0.5;
}

static bool all(const Cloud *cloud, size_t i, size_t j)
{
    (void)cloud, (void)i, (void)j;
    return true;
}

/* Does the normal of j count for i? Of another fluid where there are but two. */
static bool with_normal(const Cloud *cloud, size_t i, size_t j)
{
    const Particles *s = &cloud->s;
    return j < particles_fluid(s) && particle_has_normal(s, j) &&
           (s->phase[j] == s->phase[i] || cloud->model.n_phases == 2);
}

/* M_i of some neighbours, or the identity. */
static void correction(const Cloud *cloud, size_t i, bool corrected, bool (*counts)(const Cloud *, size_t, size_t),
                       double M[3][3])
{
    const Particles *s = &cloud->s;
    double moments[3][3] = {{0}};
    memset(M, 0, 9 * sizeof(double));
    for (int d = 0; d < 3; d++) M[d][d] = 1;
    if (!corrected) return;
    for (size_t j = 0; j < s->n; j++) {
        if (!in_reach(cloud, i, j) || !counts(cloud, i, j)) continue;
        const CloudPair pair = cloud_pair(cloud, i, j);
        for (int d = 0; d < s->dim; d++)
            for (int e = 0; e < s->dim; e++) moments[d][e] -= pair.dx[d] * pair.F * pair.dx[e] * cloud_volume(cloud, j);
    }
    cloud_invert(moments, s->dim, M);
}

/* M_i sum_j grad_i W V_j over other fluids. */
static void towards_others(const Cloud *cloud, size_t i, double M[3][3], double ret[3])
{
    const Particles *s = &cloud->s;
    double sum[3] = {0};
    for (size_t j = 0; j < particles_fluid(s); j++) {
        if (s->phase[j] == s->phase[i] || !in_reach(cloud, i, j)) continue;
        const CloudPair pair = cloud_pair(cloud, i, j);
        for (int d = 0; d < s->dim; d++) sum[d] += pair.F * pair.dx[d] * cloud_volume(cloud, j);
    }
    for (int d = 0; d < 3; d++) {
        ret[d] = 0;
        for (int e = 0; e < s->dim; e++) ret[d] += M[d][e] * sum[e];
    }
}

static double length(const double a[3])
{
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

/* From the normals there are; det: what inverses are not taken of less than is the code's (moments.h), as here all have enough of neighbours. */
static double raw(const Cloud *cloud, size_t i)
{
    const Particles *s = &cloud->s;
    double M[3][3], sum = 0;
    correction(cloud, i, true, with_normal, M);
    for (size_t j = 0; j < particles_fluid(s); j++) {
        if (!in_reach(cloud, i, j) || !with_normal(cloud, i, j)) continue;
        const CloudPair pair = cloud_pair(cloud, i, j);
        for (int d = 0; d < s->dim; d++) {
            const double e = (s->phase[j] == s->phase[i] ? 1 : -1) * s->normal[d][j] - s->normal[d][i];
            for (int k = 0; k < s->dim; k++) sum += e * M[d][k] * pair.F * pair.dx[k] * cloud_volume(cloud, j);
        }
    }
    return sum;
}

/* How many other fluids i has in reach. */
static int others_of(const Cloud *cloud, size_t i)
{
    const Particles *s = &cloud->s;
    bool has[MNS_MAX_FLUIDS] = {false};
    int n = 0;
    for (size_t j = 0; j < particles_fluid(s); j++)
        if (in_reach(cloud, i, j) && cloud_pair(cloud, i, j).F < 0) has[s->phase[j]] = true;
    for (unsigned k = 0; k < cloud->model.n_phases; k++) n += has[k] && k != s->phase[i];
    return n;
}

/* What a curvature counts for in means. */
static double weight(const Cloud *cloud, size_t i)
{
    double M[3][3], q[3];
    if (!particle_has_normal(&cloud->s, i)) return 0;
    correction(cloud, i, false, all, M);
    towards_others(cloud, i, M, q);
    return pow(cloud->model.dx * length(q), 4);
}

/* [n] to [n]. */
static void take_means(const Cloud *cloud, const double *kappa, double *ret)
{
    const Particles *s = &cloud->s;
    for (size_t i = 0; i < particles_fluid(s); i++) {
        double above = 0, below = 0;
        ret[i] = 0;
        if (others_of(cloud, i) == 0) continue;
        for (size_t j = 0; j < particles_fluid(s); j++) {
            const bool other = s->phase[j] != s->phase[i];
            if (j != i && (!in_reach(cloud, i, j) || (other && others_of(cloud, j) > 1))) continue;
            const double W = j == i ? kernel_at_zero(&cloud->model.kernel) : cloud_pair(cloud, i, j).W;
            const double c = weight(cloud, j) * W * cloud_volume(cloud, j);
            below += c;
            above += c * (other ? -1 : 1) * kappa[j];
        }
        ret[i] = below > 0 ? above / below : 0;
    }
}

/* Three fluids, of which two do not mind each other, beside a wall and a free surface. */
static Cloud *three_fluids(int dim)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {10, 11, 8},
                                           .jitter = 0.2,
                                           .skin = 0.3,
                                           .smoothing = 1.6,
                                           .periodic = {false, false, true},
                                           .flowing = true,
                                           .owner = tank});
    Particles *s = &cloud->s;
    uint64_t seed = 2;
    cloud->model.n_phases = 3;
    cloud->model.phase[2] = (Phase){.rho0 = 80, .c = 20};
    cloud->model.tension[0][2] = cloud->model.tension[2][0] = 0.2;
    tension_share(&cloud->model);
    for (size_t i = 0; i < particles_fluid(s); i++) {
        const double V = cloud_volume(cloud, i) * (1 + 0.1 * cloud_noise(&seed));
        if (s->x[0][i] >= 0.5) {
            s->phase[i] = s->phase[i] == 0 && s->x[0][i] > 0.7 ? 2 : s->phase[i];
            s->rho[i] = cloud->model.phase[s->phase[i]].rho0 * (1 + 0.05 * cloud_noise(&seed));
        }
        s->m[i] = s->rho[i] * V;
    }
    if (neighbours_build(&cloud->nb, s, &cloud->model, NULL)) abort(); /* lists know of whose fluid they are */
    return cloud;
}

static void normals_are_those_of_the_papers_among_three_fluids(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 2; k++) {
            Cloud *cloud = three_fluids(dim);
            const Particles *s = &cloud->s;
            size_t normals = 0, none = 0;
            cloud_term(cloud, FORM[k].normal);
            for (size_t i = 0; i < particles_fluid(s); i++) {
                double M[3][3], q[3];
                correction(cloud, i, FORM[k].corrected, all, M);
                towards_others(cloud, i, M, q);
                const bool valid = length(q) * cloud->model.kernel.h > 0.01;
                normals += valid;
                none += !valid;
                for (int d = 0; d < dim; d++) assert_close(s->normal[d][i], valid ? q[d] / length(q) : 0, 1e-11);
            }
            assert_true(normals > 15 && none > 3);
            cloud_free(cloud);
        }
}

/* By the sums as they are printed, of what the passes before have left. A particle with hardly any neighbours that count has no M' and is left out. */
static void curvatures_are_those_of_the_sums(void **state)
{
    (void)state;
    for (int fluids = 2; fluids <= 3; fluids++)
        for (int k = 0; k < FORMS; k++) {
            Cloud *cloud = three_fluids(2);
            Particles *s = &cloud->s;
            const size_t n = particles_fluid(s);
            double *kappa = calloc(3 * n, sizeof *kappa), *once = kappa + n, *twice = once + n;
            size_t found = 0;
            assert_non_null(kappa);
            if (fluids == 2) {
                cloud->model.n_phases = 2;
                for (size_t i = 0; i < n; i++) s->phase[i] = s->phase[i] == 2 ? 0 : s->phase[i];
                for (size_t w = n; w < s->n; w++) s->phase[w] = 2;
                tension_share(&cloud->model);
                assert_int_equal(neighbours_build(&cloud->nb, s, &cloud->model, NULL), MNS_OK);
            }
            cloud_term(cloud, FORM[k].normal);
            cloud_term(cloud, FORM[k].curvature[0]);
            const double *of = FORM[k].state ? curvature_step(s) : s->curvature;
            for (size_t i = 0; i < n; i++) {
                const double exact = particle_has_normal(s, i) ? raw(cloud, i) : 0, w = weight(cloud, i);
                const double counts = w * cloud_volume(cloud, i);
                assert_close(curvature_weights(s)[i], others_of(cloud, i) > 1 ? -counts : counts, 1e-12);
                found += fabs(of[i] - exact) < 1e-9 * (1 + fabs(exact)) && exact != 0;
                kappa[i] = of[i];
            }
            assert_true(found > 25);
            for (int step = 1; step < 4 && FORM[k].curvature[step]; step++) cloud_term(cloud, FORM[k].curvature[step]);
            take_means(cloud, kappa, once);
            take_means(cloud, once, twice);
            take_means(cloud, twice, kappa);
            for (size_t i = 0; i < n; i++) {
                const double exact =
                    FORM[k].state ? once[i] + 3 * (twice[i] - kappa[i]) : once[i] + 3 * (once[i] - twice[i]);
                if (others_of(cloud, i) > 0) assert_close(s->curvature[i], exact, 1e-9 * (1 + fabs(exact)));
            }
            free(kappa);
            cloud_free(cloud);
        }
}

/* --- flat interfaces ------------------------------------------------------------------------------------------------------- */

static double normal_of[3], offset; /* of the next plane */

static int half(const double x[3])
{
    return x[0] * normal_of[0] + x[1] * normal_of[1] + x[2] * normal_of[2] < offset ? CLOUD_WATER : CLOUD_AIR;
}

static Cloud *flat(int dim, const double n[3], double at, double ratio)
{
    const double size = length(n);
    for (int d = 0; d < 3; d++) normal_of[d] = n[d] / size;
    offset = at / size;
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {15, 15, 15},
                                           .smoothing = 1.6,
                                           .skin = 0.3,
                                           .flowing = true,
                                           .calibrated = true,
                                           .owner = half});
    cloud_weigh(cloud, 1, 1000 / ratio);
    return cloud;
}

/* So far from the cloud's rim that its neighbours have the normals of a plane too. */
static bool deep(const Cloud *cloud, size_t i)
{
    for (int d = 0; d < cloud->s.dim; d++) {
        const double x = cloud->s.x[d][i], margin = 2 * cloud->model.kernel.support;
        if (x < margin || x > cloud->model.max[d] - margin) return false;
    }
    return true;
}

static void flat_interfaces_have_their_normal_and_no_curvature(void **state)
{
    (void)state;
    static const double planes[3][4] = {{0, 1, 0, 0.7}, {1, 1, 0, 1.42}, {1, 1, 1, 2.27}};
    for (int dim = 2; dim <= 3; dim++)
        for (int plane = 0; plane < dim; plane++)
            for (int k = 0; k < FORMS; k++) {
                Cloud *cloud = flat(dim, planes[plane], planes[plane][3], k & 1 ? 1000 : 1);
                const Particles *s = &cloud->s;
                size_t found = 0;
                cloud_term(cloud, FORM[k].normal);
                cloud_term(cloud, FORM[k].curvature[0]);
                const double *raw_one = FORM[k].state ? curvature_step(s) : s->curvature;
                for (size_t i = 0; i < s->n; i++) {
                    if (!cloud_inner(cloud, i) || !particle_has_normal(s, i)) continue;
                    const double sign = s->phase[i] == 0 ? 1 : -1; /* towards the other */
                    for (int d = 0; d < dim; d++) assert_close(s->normal[d][i], sign * normal_of[d], 1e-14);
                }
                for (size_t i = 0; i < s->n; i++) {
                    if (!deep(cloud, i)) continue;
                    found += particle_has_normal(s, i);
                    assert_close(raw_one[i], 0, 1e-11); /* what rounding leaves, over dx = 0.1 */
                }
                assert_true(found > 3);
                cloud_free(cloud);
            }
}

/* What is the same everywhere, but for the side it is seen from, is its mean, and the sharper one too. */
static void means_of_what_is_the_same_are_that(void **state)
{
    (void)state;
    static const double kappa = 1.7;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < FORMS; k++) {
            Cloud *cloud = flat(dim, (const double[3]){1, 1, 0}, 1.42, 1000);
            Particles *s = &cloud->s;
            size_t found = 0;
            cloud_term(cloud, FORM[k].normal);
            cloud_term(cloud, FORM[k].curvature[0]);
            double *first = FORM[k].state ? curvature_step(s) : s->curvature;
            for (size_t i = 0; i < s->n; i++) first[i] = s->phase[i] == 0 ? kappa : -kappa;
            for (int step = 1; step < 4 && FORM[k].curvature[step]; step++) cloud_term(cloud, FORM[k].curvature[step]);
            for (size_t i = 0; i < s->n; i++) {
                if (!particle_has_normal(s, i)) continue;
                assert_close(s->curvature[i], s->phase[i] == 0 ? kappa : -kappa, 1e-12);
                found++;
            }
            assert_true(found > 20);
            cloud_free(cloud);
        }
}

/* --- circles and balls ----------------------------------------------------------------------------------------------------- */

static double radius, middle;

static int drop(const double x[3])
{
    const double r2 = pow(x[0] - middle, 2) + pow(x[1] - middle, 2) + (x[2] > 0 ? pow(x[2] - middle, 2) : 0);
    return r2 < radius * radius ? CLOUD_WATER : CLOUD_AIR;
}

/* Of J over sigma (dim - 1)/R, over the pairs across the surface of a drop of R/dx = size: the mean less 1, and the deviation. */
typedef struct Error {
    double mean, deviation;
} Error;

static Error error_of(int dim, MnsKernel kernel, double smoothing, const Form *form, double size, double jitter)
{
    const size_t n = 2 * (size_t)(size + 4 * smoothing) + 6;
    radius = 0.1 * size;
    middle = 0.05 * (double)n;
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {n, n, n},
                                           .kernel = kernel,
                                           .smoothing = smoothing,
                                           .jitter = jitter,
                                           .flowing = true,
                                           .calibrated = true,
                                           .owner = drop});
    const Particles *s = &cloud->s;
    double sum = 0, squares = 0, pairs = 0;
    find_curvature(cloud, form);
    for (size_t i = 0; i < s->n; i++) {
        const Jump jump = jump_of(s, &cloud->model, i, 1);
        for (size_t k = 0; s->phase[i] == 0 && k < cloud->nb.end[i][END_WALLS]; k++) {
            const uint32_t j = neighbours_of(&cloud->nb, i)[k], block[LANES] = {j, j, j, j, j, j, j, j};
            double J[LANES];
            if (s->phase[j] == 0 || !in_reach(cloud, i, j)) continue;
            jumps_of(&jump, s, block, J);
            const double relative = J[0] * radius / (SIGMA * (dim - 1)) - 1;
            sum += relative;
            squares += relative * relative;
            pairs++;
        }
    }
    cloud_free(cloud);
    return (Error){sum / pairs, sqrt(squares / pairs)};
}

static void curvatures_of_circles_converge(void **state)
{
    (void)state;
    for (int k = 0; k < FORMS; k++) {
        const Error five = error_of(2, MNS_WENDLAND_C2, 1.6, &FORM[k], 5, 0),
                    ten = error_of(2, MNS_WENDLAND_C2, 1.6, &FORM[k], 10, 0),
                    twenty = error_of(2, MNS_WENDLAND_C2, 1.6, &FORM[k], 20, 0),
                    uneven = error_of(2, MNS_WENDLAND_C2, 1.6, &FORM[k], 20, 0.05);
        print_message("%d: %.4f (%.4f)  %.4f (%.4f)  %.4f (%.4f)  uneven %.4f (%.4f)\n", k, five.mean, five.deviation,
                      ten.mean, ten.deviation, twenty.mean, twenty.deviation, uneven.mean, uneven.deviation);
        assert_less(fabs(ten.mean), 0.02);
        assert_less(fabs(twenty.mean), 0.01);
        assert_less(fabs(uneven.mean), 0.02);
    }
}

static void balls_have_twice_the_curvature(void **state)
{
    (void)state;
    for (int k = 0; k < FORMS; k++) {
        const Error eight = error_of(3, MNS_WENDLAND_C2, 1.6, &FORM[k], 8, 0);
        print_message("%d: %.4f (%.4f)\n", k, eight.mean, eight.deviation);
        assert_less(fabs(eight.mean), 0.03);
    }
}

/* --- walls ----------------------------------------------------------------------------------------------------------------- */

/* Planes of symmetry through the middle of a cloud: bit d of `cut` for the one across direction d. What is below is wall. */
static unsigned cut;
static bool block;       /* only the part of a wall where x is above the middle */
static double across_at; /* of flat interfaces, along x; 0: a drop */

static int mirrored(const double x[3])
{
    for (int d = 0; d < 3; d++)
        if (cut >> d & 1 && x[d] < middle && !(block && x[0] < middle)) return CLOUD_WALL;
    return across_at > 0 ? x[0] < across_at ? CLOUD_WATER : CLOUD_AIR : drop(x);
}

/* Displace all fluid alike on both sides of every plane. */
static void stir_alike(Cloud *cloud)
{
    Particles *s = &cloud->s;
    const int dim = s->dim;
    for (size_t i = 0; i < particles_fluid(s); i++) {
        uint64_t seed = 5;
        double off[3];
        for (int d = 0; d < dim; d++) seed = seed * 1000 + (uint64_t)(fabs(s->x[d][i] - middle) * 10);
        for (int d = 0; d < dim; d++) off[d] = 0.02 * cloud_noise(&seed);
        for (int d = 0; d < dim; d++) s->x[d][i] += s->x[d][i] < middle ? -off[d] : off[d];
    }
    assert_int_equal(cloud_build(cloud), MNS_OK);
}

/* With walls that have moved a bit since the case put them. */
static Cloud *cut_cloud(int dim, size_t n, unsigned planes, bool stirred)
{
    static Face face[3];
    static const double moved = 0.3;
    cut = planes;
    middle = 0.05 * (double)n;
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {n, n, n},
                                           .smoothing = 1.6,
                                           .skin = 0.3,
                                           .flowing = true,
                                           .calibrated = true,
                                           .owner = mirrored});
    Model *model = &cloud->model;
    model->face = face;
    for (int d = 0; d < dim; d++) {
        model->wall[0].x[d] = moved;
        if (!(planes >> d & 1)) continue;
        face[model->n_faces] = (Face){.wall = 0};
        face[model->n_faces].point[d] = middle - moved;
        face[model->n_faces++].normal[d] = 1;
    }
    if (stirred) stir_alike(cloud);
    return cloud;
}

/* Fluid of a cloud with walls has the normals and curvatures that it has in the whole. Returns how many have a normal beside walls. */
static size_t assert_like_the_whole(const Cloud *whole, const Cloud *part)
{
    const Particles *s = &part->s, *t = &whole->s;
    size_t beside = 0;
    double largest = 0;
    for (size_t i = 0; i < t->n; i++) largest = fmax(largest, fabs(t->curvature[i]));
    for (size_t i = 0; i < particles_fluid(s); i++) {
        const size_t j = cloud_index(whole, s->id[i]);
        beside += particle_has_normal(s, i) && part->nb.has[i] & LIST_WALLS;
        for (int d = 0; d < s->dim; d++) {
            assert_close(s->normal[d][i], t->normal[d][j], 1e-9);
        }
        assert_close(s->curvature[i], t->curvature[j], 1e-9 * largest);
    }
    return beside;
}

static void parts_of_drops_between_walls_are_like_the_whole(void **state)
{
    (void)state;
    across_at = 0;
    radius = 0.73;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < FORMS; k++) {
            const size_t n = dim == 2 ? 32 : 24;
            Cloud *whole = cut_cloud(dim, n, 0, true);
            find_curvature(whole, &FORM[k]);
            for (unsigned planes = 1; planes < 1u << dim; planes++) {
                Cloud *part = cut_cloud(dim, n, planes, true);
                find_curvature(part, &FORM[k]);
                assert_true(assert_like_the_whole(whole, part) > 20);
                cloud_free(part);
            }
            cloud_free(whole);
        }
}

static void interfaces_at_right_angles_to_walls_are_flat(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < FORMS; k++) {
            size_t found = 0;
            across_at = 1.6;
            Cloud *cloud = cut_cloud(dim, 30, 2, false);
            const Particles *s = &cloud->s;
            cloud_term(cloud, FORM[k].normal);
            cloud_term(cloud, FORM[k].curvature[0]);
            const double *raw_one = FORM[k].state ? curvature_step(s) : s->curvature;
            for (size_t i = 0; i < particles_fluid(s); i++) {
                if (!deep(cloud, i)) continue;
                const double sign = particle_has_normal(s, i) ? s->phase[i] == 0 ? 1 : -1 : 0;
                found += sign != 0 && cloud->nb.has[i] & LIST_WALLS;
                for (int d = 0; d < dim; d++) assert_close(s->normal[d][i], d == 0 ? sign : 0, 1e-13);
                assert_close(raw_one[i], 0, 1e-10);
            }
            assert_true(found > 8);
            cloud_free(cloud);
        }
    across_at = 0;
}

/* A block below the right half: its top mirrors what is above it, and nothing beyond its edge. */
static void walls_mirror_no_farther_than_they_reach(void **state)
{
    (void)state;
    size_t above = 0, beyond = 0;
    block = true;
    across_at = 1.55;
    Cloud *with = cut_cloud(2, 30, 2, false), *without = cut_cloud(2, 30, 2, false);
    without->model.n_faces = 0;
    cloud_term(with, &interface_normal);
    cloud_term(without, &interface_normal);
    for (size_t i = 0; i < particles_fluid(&with->s); i++) {
        const size_t j = cloud_index(without, with->s.id[i]);
        const bool same = with->s.normal[1][i] == without->s.normal[1][j];
        const double x = with->s.x[0][i], y = with->s.x[1][i];
        if (!particle_has_normal(&with->s, i) || !(with->nb.has[i] & LIST_WALLS) || y < middle) continue;
        if (x < middle - 0.1) assert_true(same);
        beyond += x < middle - 0.1;
        above += x > middle && !same;
    }
    assert_true(beyond > 1 && above > 3);
    with->model.tense = false; /* normals are for the shifting alone then */
    cloud_term(with, &interface_normal);
    for (size_t i = 0; i < particles_fluid(&with->s); i++) {
        const size_t j = cloud_index(without, with->s.id[i]);
        for (int d = 0; d < 2; d++) assert_true(with->s.normal[d][i] == without->s.normal[d][j]);
    }
    cloud_free(with);
    cloud_free(without);
    block = false;
    across_at = 0;
}

static void without_other_fluids_there_is_neither_normal_nor_curvature(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < FORMS; k++) {
            Cloud *cloud = flat(dim, (const double[3]){0, 1, 0}, 0.7, 1000);
            Particles *s = &cloud->s;
            for (size_t i = 0; i < s->n; i++) {
                for (int d = 0; d < dim; d++) s->normal[d][i] = 5; /* of a step before */
                s->curvature[i] = curvature_step(s)[i] = curvature_weights(s)[i] = 5;
            }
            find_curvature(cloud, &FORM[k]);
            size_t far = 0;
            for (size_t i = 0; i < s->n; i++) {
                if (fabs(s->x[1][i] - 0.7) < cloud->model.kernel.support + 0.05) continue;
                far++;
                for (int d = 0; d < dim; d++) assert_true(s->normal[d][i] == 0);
                assert_true(s->curvature[i] == 0 && curvature_step(s)[i] == 0 && curvature_weights(s)[i] == 0);
            }
            assert_true(far > 20);
            cloud->model.tense = false;
            for (int step = 0; step < 4 && FORM[k].curvature[step]; step++)
                assert_false(FORM[k].curvature[step]->needed(&cloud->model));
            assert_true(FORM[k].normal->needed(&cloud->model)); /* by the shifting */
            cloud->model.shifts_along_interfaces = false;
            assert_false(FORM[k].normal->needed(&cloud->model));
            cloud_free(cloud);
        }
}

/* --- jumps ----------------------------------------------------------------------------------------------------------------- */

/* Of three fluids each has its own share, so that what the curvature of a surface pulls with is that of both it parts; where it pays one to lie between
 * the others its share is below 0. */
static void shares_of_two_fluids_are_their_tension(void **state)
{
    (void)state;
    Model model = {.n_phases = 3};
    static const double tension[3][3] = {{0, 0.7, 0.1}, {0.7, 0, 0.3}, {0.1, 0.3, 0}};
    memcpy(model.tension[0], tension[0], sizeof tension[0]);
    memcpy(model.tension[1], tension[1], sizeof tension[1]);
    memcpy(model.tension[2], tension[2], sizeof tension[2]);
    tension_share(&model);
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            if (a != b) assert_close(model.tension_share[a][b] + model.tension_share[b][a], tension[a][b], 1e-15);
    assert_close(model.tension_share[2][0], -0.15, 1e-15);
    assert_close(model.tension_share[2][1], -0.15, 1e-15);
    /* A fourth one that minds the others as the third does leaves their shares alone, and two that are as one have one's. */
    model.n_phases = 4;
    for (int a = 0; a < 3; a++) model.tension[a][3] = model.tension[3][a] = tension[a][2];
    tension_share(&model);
    assert_close(model.tension_share[0][1], 0.25, 1e-15);
    assert_close(model.tension_share[1][0], 0.45, 1e-15);
    for (int a = 0; a < 4; a++)
        for (int b = 0; b < 4; b++)
            if (a != b) assert_close(model.tension_share[a][b] + model.tension_share[b][a], model.tension[a][b], 1e-15);
    model.n_phases = 2;
    tension_share(&model);
    assert_true(model.tension_share[0][1] == 0.35 && model.tension_share[1][0] == 0.35);
}

static void jumps_are_opposite_to_the_last_bit_and_none_within_a_fluid(void **state)
{
    (void)state;
    Cloud *cloud = three_fluids(2);
    Particles *s = &cloud->s;
    uint64_t seed = 12;
    size_t unlike = 0;
    for (size_t i = 0; i < particles_fluid(s); i++) s->curvature[i] = 30 * cloud_noise(&seed);
    for (size_t i = 0; i < particles_fluid(s); i++)
        for (size_t j = 0; j < i; j++) {
            const uint32_t of_i[LANES] = {[0] = (uint32_t)i}, of_j[LANES] = {[0] = (uint32_t)j};
            const Jump a = jump_of(s, &cloud->model, i, 0.1), b = jump_of(s, &cloud->model, j, 0.1);
            double J_ij[LANES], J_ji[LANES];
            jumps_of(&a, s, of_j, J_ij);
            jumps_of(&b, s, of_i, J_ji);
            assert_true(J_ij[0] == -J_ji[0]);
            if (s->phase[i] == s->phase[j]) assert_true(J_ij[0] == 0);
            else unlike += J_ij[0] != 0;
        }
    assert_true(unlike > 50);
    cloud_free(cloud);
}

/* A drop whose pressure is that of a curvature known exactly feels what it feels of one pressure everywhere: nothing, in its inner on a lattice, and
 * dissipates nothing. */
static void a_drop_of_exact_curvature_is_at_rest(void **state)
{
    (void)state;
    static const Term *const forces[] = {&pressure_force, &volume_pressure_force, &density_dissipation};
    static const double inside = 9, outside = 2;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 3; k++)
            for (int tilted = 0; tilted < 2; tilted++) {
                radius = 0.55;
                middle = 0.8;
                Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                                       .dx = 0.1,
                                                       .n = {16, 16, 16},
                                                       .smoothing = 1.3,
                                                       .periodic = {true, true, true},
                                                       .flowing = true,
                                                       .calibrated = true,
                                                       .owner = drop});
                Particles *s = &cloud->s;
                cloud->model.repulsion = 0;
                cloud->model.own_gradients = 1;
                cloud->model.density_average = tilted ? 1 : 0;
                for (size_t i = 0; i < s->n; i++) {
                    s->p[i * s->p_step] = s->phase[i] == 0 ? inside : outside;
                    s->curvature[i] = (s->phase[i] == 0 ? 1 : -1) * (inside - outside) / SIGMA;
                    s->m[i] = s->rho[i] * cloud->model.cell_volume;
                }
                cloud_term(cloud, &pressure_gradient);
                cloud_term(cloud, forces[k]);
                for (size_t i = 0; i < s->n; i++) {
                    for (int d = 0; d < dim; d++) assert_close(s->a[d][i] * s->rho[i], 0, 1e-10);
                    assert_close(s->rate[i] / s->rho[i], 0, 1e-12);
                }
                cloud_free(cloud);
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(normals_are_those_of_the_papers_among_three_fluids),
        cmocka_unit_test(curvatures_are_those_of_the_sums),
        cmocka_unit_test(flat_interfaces_have_their_normal_and_no_curvature),
        cmocka_unit_test(means_of_what_is_the_same_are_that),
        cmocka_unit_test(curvatures_of_circles_converge),
        cmocka_unit_test(balls_have_twice_the_curvature),
        cmocka_unit_test(parts_of_drops_between_walls_are_like_the_whole),
        cmocka_unit_test(interfaces_at_right_angles_to_walls_are_flat),
        cmocka_unit_test(walls_mirror_no_farther_than_they_reach),
        cmocka_unit_test(without_other_fluids_there_is_neither_normal_nor_curvature),
        cmocka_unit_test(shares_of_two_fluids_are_their_tension),
        cmocka_unit_test(jumps_are_opposite_to_the_last_bit_and_none_within_a_fluid),
        cmocka_unit_test(a_drop_of_exact_curvature_is_at_rest),
    };
    return cmocka_run_group_tests_name("curvature", tests, NULL, NULL);
}
