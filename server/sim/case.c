/* SPDX-License-Identifier: BSD-3-Clause */
/* The end of a case's life; what a case may say is checked elsewhere. */
#include <meniscus/case.h>
#include <stdlib.h>

static void free_three(char *texts[3])
{
    for (int d = 0; d < 3; d++) free(texts[d]);
}

static void free_shape(MnsShape *shape)
{
    for (size_t k = 0; k < shape->n; k++) free(shape->parts[k].formula);
    free(shape->parts);
}

static void free_fluid(MnsFluid *fluid)
{
    free(fluid->name);
    free_shape(&fluid->shape);
    free_three(fluid->velocity);
    free(fluid->pressure);
}

static void free_wall(MnsWall *wall)
{
    free(wall->name);
    free_shape(&wall->shape);
    free(wall->motion.points);
    free_three(wall->surface_velocity);
}

static void free_constants(MnsCase *c)
{
    for (size_t k = 0; k < c->n_constants; k++) {
        free(c->constants[k].name);
        free(c->constants[k].value);
    }
    free(c->constants);
}

static void free_probes(MnsCase *c)
{
    for (size_t k = 0; k < c->n_probes; k++) {
        free(c->probes[k].name);
        free(c->probes[k].field);
        free(c->probes[k].formula);
    }
    free(c->probes);
}

void mns_case_free(MnsCase *c)
{
    if (!c) return;
    for (size_t k = 0; k < c->n_fluids; k++) free_fluid(&c->fluids[k]);
    for (size_t k = 0; k < c->n_walls; k++) free_wall(&c->walls[k]);
    for (size_t k = 0; k < c->output.n_fields; k++) free(c->output.fields[k]);
    free_constants(c);
    free_probes(c);
    free_three(c->gravity);
    free_three(c->displacement);
    free(c->fluids);
    free(c->walls);
    free(c->output.fields);
    free(c->title);
    free(c);
}
