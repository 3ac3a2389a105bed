/* SPDX-License-Identifier: BSD-3-Clause */
/* What the tables of all schemes say of themselves is so: terms and local rules write what they declare, of the groups they are
 * for, and nothing else. Copies for neighbours are made again by these declarations alone. */
#include "sim/terms/curvature.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <stdlib.h>
#include <string.h>

static int three_kinds(const double x[3])
{
    return x[1] < 0.3 ? CLOUD_WALL : x[0] < 0.5 ? CLOUD_WATER : CLOUD_AIR;
}

static int liquid_alone(const double x[3])
{
    return x[1] < 0.3 ? CLOUD_WALL : CLOUD_WATER;
}

/* Two fluids and a wall, or one liquid that fills a closed space, with corrected gradients. */
static Cloud *stirred(int dim, bool closed, bool reconstructs)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {10, 9, 8},
                                           .jitter = 0.3,
                                           .skin = 0.3,
                                           .viscous = true,
                                           .reconstructs = reconstructs,
                                           .owner = closed ? liquid_alone : three_kinds});
    cloud->model.closed = cloud->model.corrects_gradients = closed;
    if (closed) cloud->model.phase[1].summation = false;
    cloud->model.wall[0].no_slip = true;
    cloud_stir(cloud, 11);
    uint64_t seed = 4;
    for (int d = 0; d < dim; d++) {
        cloud->model.gravity[d] = -1 - d;
        for (size_t i = 0; i < cloud->s.n; i++) {
            cloud->s.b[d][i] = 300 * cloud_noise(&seed);
            cloud->s.curvature[i] = 3 * cloud_noise(&seed);
            curvature_step(&cloud->s)[i] = 3 * cloud_noise(&seed);
            curvature_weights(&cloud->s)[i] = 0.1 + 0.05 * cloud_noise(&seed);
            cloud->s.a[d][i] = 3 * cloud_noise(&seed);
            if (cloud->s.normal[d]) cloud->s.normal[d][i] = d == (int)(i % 2) ? 0.6 : d < 2 ? 0.8 : 0;
            cloud->s.concentration[d][i] = 5 * cloud_noise(&seed);
            if (cloud->s.gradient[d]) cloud->s.gradient[d][i] = 9e3 * cloud_noise(&seed);
            cloud->s.correction[d][i] = 2 + cloud_noise(&seed);
            cloud->s.correction_off[d][i] = 0.2 * cloud_noise(&seed);
            cloud->s.offset[d][i] = cloud_noise(&seed);
            cloud->s.colour_gradient[d][i] = cloud_noise(&seed);
            const double to_surface = 0.1 * (1 + d + cloud_noise(&seed));
            const size_t n = particles_fluid(&cloud->s);
            if (i >= n) cloud->s.to_surface[d][i - n] = to_surface;
        }
    }
    for (size_t k = 0; k < cloud->system.matrix.n; k++) cloud->system.x[k] = cloud_noise(&seed);
    for (size_t i = 0; i < cloud->s.n; i++) {
        cloud->s.rate[i] = 0.5 + 0.1 * cloud_noise(&seed);
        cloud->s.rho[i] *= 1.01; /* what follows from it is out of date */
        cloud->s.laplacian[i] = 3 + cloud_noise(&seed);
        cloud->s.colour[i] = 0.5 + 0.5 * cloud_noise(&seed);
    }
    return cloud;
}

/* All fields of all particles, one after the other. */
static char *copy_of(const Particles *s)
{
    char *copy = NULL;
    size_t size = 0;
    for (int f = 0; mns_fields()[f].name; f++)
        for (int d = 0; d < 3; d++) {
            const char *array = particles_field(s, f, d);
            const Owners owners = particles_owners(s, f);
            const size_t bytes = (owners.last - owners.first) * field_size(&mns_fields()[f]);
            if (!array) continue;
            copy = realloc(copy, size + bytes);
            assert_non_null(copy);
            memcpy(copy + size, array, bytes);
            size += bytes;
        }
    return copy;
}

/* What has changed since the copy was made must have been declared; returns the fields that have. */
static Fields changes(const Particles *s, const char *copy, const char *name, unsigned on, Fields writes)
{
    Fields found = 0;
    for (int f = 0; mns_fields()[f].name; f++)
        for (int d = 0; d < 3; d++) {
            const char *array = particles_field(s, f, d);
            const Owners owners = particles_owners(s, f);
            const size_t size = field_size(&mns_fields()[f]);
            if (!array) continue;
            for (int g = 0; g < GROUPS; g++) {
                if (s->begin[g] < owners.first) continue;
                const size_t first = (s->begin[g] - owners.first) * size,
                             bytes = (s->begin[g + 1] - s->begin[g]) * size;
                if (memcmp(array + first, copy + first, bytes) == 0) continue;
                found |= UINT64_C(1) << f;
                if (!(on >> g & 1) || !(writes >> f & 1))
                    fail_msg("%s writes %s of group %d without saying so", name, mns_fields()[f].name, g);
            }
            copy += (owners.last - owners.first) * size;
        }
    return found;
}

/* Is it of what dissipates beside linear flows alone? */
static bool is_of_strain(const Term *term)
{
    return term && term->needed && term->needed(&(Model){.reconstructs = true}) && !term->needed(&(Model){0});
}

/* A term or a local rule, the other being NULL. */
static void assert_declared(const Term *term, const Local *local, int dim)
{
    const char *name = term ? term->name : local->name;
    const Fields writes = term ? term->writes : local->writes;
    Fields found = 0, stored = 0;
    for (int k = 0; k < 8; k++) {
        Cloud *cloud = stirred(dim, k % 2, is_of_strain(term));
        stored = cloud->s.fields;
        cloud->model.differences.diffusion = (MnsDiffusion)(k / 2);
        cloud->model.radial = k & 2;
        cloud->model.spared = k & 1 ? SPARED_SLOPES : SPARED_NOTHING;
        cloud->model.any_fills = cloud->model.phase[1].fills = k >= 4;
        cloud->model.phase[1].resists = k >= 4 ? 1 : 0;
        char *before = copy_of(&cloud->s);
        const Pass pass = {"alone", .terms = {term}};
        if (term) pass_run(&pass, &cloud->s, &cloud->nb, &cloud->model, 1);
        else local_run(local, &cloud->s, &cloud->model, 1);
        found |= changes(&cloud->s, before, name, term ? term->on : local->on, writes);
        free(before);
        cloud_free(cloud);
    }
    if (found != (writes & stored)) fail_msg("%s does not write all that it declares", name);
}

static void terms_and_rules_write_what_they_declare_and_nothing_else(void **state)
{
    (void)state;
    char text[32768];
    const char *name = NULL;
    for (size_t k = 0; (name = mns_scheme_describe(k, text, sizeof text)); k++)
        for (int dim = 2; dim <= 3; dim++)
            for (const Pass *pass = scheme_find(name)->rates; pass->name; pass++) {
                for (int q = 0; q < PASS_TERMS_MAX && pass->terms[q]; q++) assert_declared(pass->terms[q], NULL, dim);
                for (int q = 0; q < PASS_LOCALS_MAX && pass->before[q]; q++)
                    assert_declared(NULL, pass->before[q], dim);
                for (int q = 0; q < PASS_LOCALS_MAX && pass->after[q]; q++) assert_declared(NULL, pass->after[q], dim);
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(terms_and_rules_write_what_they_declare_and_nothing_else),
    };
    return cmocka_run_group_tests_name("scheme", tests, NULL, NULL);
}
