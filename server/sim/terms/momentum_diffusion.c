/* SPDX-License-Identifier: BSD-3-Clause */
/* How momentum of fluids of unlike viscosity spreads.                                                              P5 eq. 12, 13, 18, 19
 *   harmonic      rho du/dt = 2 dim/D_i sum_j mu_ij (u_j - u_i) k_ij,   mu_ij = 2 mu~_i mu~_j/(mu~_i + mu~_j)
 *   divtau        du/dt = <grad mu/rho> . (<grad u> + <grad u>^T) + mu~_i/rho~_i <lap u>,   <grad mu/rho> = (mu_0 - mu_1) <grad C/rho>
 *   conservative  harmonic, and rho <grad mu/rho> . <grad u>^T
 *   sph           rho du/dt = 1/V_i sum_j mu_ij (V_i^2 + V_j^2) (u_i - u_j) F
 * P5 prints u_i - u_j in the first, which makes momentum gather. It is not mu lap u but div(mu grad u); what it lacks of div tau is
 * grad mu . grad u^T, which is nothing in a parallel shear (schemes/differences.md). */
#include "sim/terms/average.h"
#include "sim/terms/differences.h"
#include "sim/terms/terms.h"
#include "sim/terms/wall_power.h"

static bool spreads(const Model *model, MnsDiffusion diffusion)
{
    return model->viscous && model->differences.diffusion == diffusion;
}

static bool is_harmonic(const Model *model)
{
    return spreads(model, MNS_DIFFUSION_HARMONIC);
}

static bool is_divtau(const Model *model)
{
    return spreads(model, MNS_DIFFUSION_DIVTAU);
}

static bool is_conservative(const Model *model)
{
    return spreads(model, MNS_DIFFUSION_CONSERVATIVE);
}

static bool is_sph(const Model *model)
{
    return spreads(model, MNS_DIFFUSION_SPH);
}

/* Add scale * sum_j mu (u_j - u_i) 2 dim k_ij/D_i; mu: the harmonic mean, or 1. */
INLINE void spread(const Row *row, Particles *s, const Model *model, bool harmonic, double scale, How how)
{
    const size_t i = row->i;
    const Stencil stencil = stencil_of(s, i, how);
    const Mixture mixing = mixture_of_viscosities(model);
    const double mu = mixed(mixing, s->colour[i]);
    double u[3];
    Lanes sum[3] = {0};
    for (int d = 0; d < how.dim; d++) u[d] = s->v[d][i * s->v_step];
    for (const Block *b = row->block; b < row->block + row->n; b++) {
        double colour[LANES], v[3][LANES];
        gather(s->colour, row_j(row, b), colour);
        gather_velocities(row, b, s, how, v);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            double x[3];
            for (int d = 0; d < how.dim; d++) x[d] = b->x[d][l];
            const double k = LAPLACIAN_WEIGHT(stencil, x, b->W[l], how);
            const double c = harmonic ? harmonic_mean(mu, mixed(mixing, colour[l])) * k : k;
            for (int d = 0; d < how.dim; d++) add_product(&sum[d], l, c, v[d][l] - u[d], how);
        }
    }
    for (int d = 0; d < how.dim; d++) s->a[d][i] += scale * lanes_sum(&sum[d]);
}

/* ret[b][a] = d_a u_b */
INLINE void velocity_gradient(const Row *row, const Particles *s, const Model *model, How how, double ret[3][3])
{
    const size_t i = row->i;
    Lanes sum[3][3] = {0};
    double u[3];
    for (int d = 0; d < how.dim; d++) u[d] = s->v[d][i * s->v_step];
    for (const Block *b = row->block; b < row->block + row->n; b++) {
        double v[3][LANES];
        gather_velocities(row, b, s, how, v);
#pragma omp simd
        for (int l = 0; l < LANES; l++)
            for (int d = 0; d < how.dim; d++) {
                const double du = b->W[l] * (u[d] - v[d][l]);
                for (int e = 0; e < how.dim; e++) add_product(&sum[d][e], l, du, b->x[e][l], how);
            }
    }
    for (int d = 0; d < how.dim; d++) gradient_of(s, i, model, sum[d], how, ret[d]);
}

/* Add <grad mu/rho> . grad u^T, and with `both` <grad mu/rho> . grad u: nothing but beside an interface. */
INLINE void turn(const Row *row, Particles *s, const Model *model, bool both, How how)
{
    const size_t i = row->i;
    const double jump = model->phase[0].mu - model->phase[model->n_phases - 1].mu;
    double n[3], gradient[3][3];
    for (int d = 0; d < how.dim; d++) n[d] = jump * s->colour_gradient[d][i];
    if (!(DOT(n, n, how) > 0)) return;
    velocity_gradient(row, s, model, how, gradient);
    for (int b = 0; b < how.dim; b++)
        for (int a = 0; a < how.dim; a++) s->a[b][i] += n[a] * (gradient[a][b] + (both ? gradient[b][a] : 0));
}

INLINE void harmonic_diffusion_row(const Row *row, Particles *s, const Model *model, How how)
{
    spread(row, s, model, true, 1 / density_around(s, model, row->i), how);
}
ROW_FUNCTIONS(harmonic_diffusion_row)

INLINE void divtau_diffusion_row(const Row *row, Particles *s, const Model *model, How how)
{
    const double mu = mixed(mixture_of_viscosities(model), s->colour[row->i]);
    spread(row, s, model, false, mu / density_around(s, model, row->i), how);
    turn(row, s, model, true, how);
}
ROW_FUNCTIONS(divtau_diffusion_row)

INLINE void conservative_diffusion_row(const Row *row, Particles *s, const Model *model, How how)
{
    spread(row, s, model, true, 1 / density_around(s, model, row->i), how);
    turn(row, s, model, false, how);
}
ROW_FUNCTIONS(conservative_diffusion_row)

/* With the slope of the kernel as it is printed: a calibrated one is exact on a lattice, where the printed is off by 1 to 2 %. */
INLINE void sph_diffusion_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const double printed = model->kernel.alpha / model->kernel.beta;
    const Mixture mixing = mixture_of_viscosities(model);
    const double mu = mixed(mixing, s->colour[i]), V = particles_volume(s, model, i);
    double u[3];
    Lanes sum[3] = {0};
    for (int d = 0; d < how.dim; d++) u[d] = s->v[d][i * s->v_step];
    for (const Block *b = row->block; b < row->block + row->n; b++) {
        double colour[LANES], v[3][LANES];
        gather(s->colour, row_j(row, b), colour);
        gather_velocities(row, b, s, how, v);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const double c = harmonic_mean(mu, mixed(mixing, colour[l])) * (V * V + b->V[l] * b->V[l]) * b->F[l];
            for (int d = 0; d < how.dim; d++) add_product(&sum[d], l, c, u[d] - v[d][l], how);
        }
    }
    for (int d = 0; d < how.dim; d++) s->a[d][i] += printed * lanes_sum(&sum[d]) / (V * density_around(s, model, i));
}
ROW_FUNCTIONS(sph_diffusion_row)

/* Of the same differences as the diffusion's, to wall particles: on a particle they are no forces that walls have the opposite of, but their sum is
 * that of the stress along a wall. */
INLINE void diffusion_power_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const bool paired = is_sph(model), harmonic = !is_divtau(model);
    const Stencil stencil = stencil_of(s, i, how);
    const Mixture mixing = mixture_of_viscosities(model);
    const double mu = mixed(mixing, s->colour[i]), V = particles_volume(s, model, i),
                 printed = model->kernel.alpha / model->kernel.beta;
    double u[3];
    Lanes power = {0};
    for (int d = 0; d < how.dim; d++) u[d] = s->v[d][i * s->v_step];
    for (const Block *b = row->block + row->n_fluid; b < row->block + row->n; b++) {
        double colour[LANES], v[3][LANES];
        Lanes force[3] = {0};
        gather(s->colour, row_j(row, b), colour);
        gather_velocities(row, b, s, how, v);
        for (int l = 0; l < LANES; l++) {
            const double x[3] = {b->x[0][l], b->x[1][l], how.dim == 3 ? b->x[2][l] : 0};
            const double between = harmonic ? harmonic_mean(mu, mixed(mixing, colour[l])) : mu;
            const double c = paired ? -printed * (V * V + model->cell_volume * model->cell_volume) / V * b->F[l]
                                    : LAPLACIAN_WEIGHT(stencil, x, b->W[l], how);
            for (int d = 0; d < how.dim; d++) add_product(&force[d], l, between * c, v[d][l] - u[d], how);
        }
        add_surface_power(force, s, row, b, how, &power);
    }
    s->power[i] += s->m[i] / density_around(s, model, i) * lanes_sum(&power);
}
ROW_FUNCTIONS(diffusion_power_row)

SURFACE_POWER(diffusion_power, "power of friction", "P5 eq. 12, 13, 18", "sum_w f_iw . v_w, f of the diffusion",
              is_viscous, NEED_W | NEED_F | NEED_V);

const Term harmonic_diffusion = {
    .name = "harmonic diffusion",
    .source = "P5 eq. 12, its sign as eq. 9",
    .equation = "rho~_i du_i/dt = 2 dim/D_i sum_j mu_ij (u_j - u_i) k_ij,  mu_ij = 2 mu~_i mu~_j/(mu~_i + mu~_j)",
    .on = ON_FLUID,
    .needed = is_harmonic,
    .needs = NEED_W | NEED_V,
    .writes = FIELD(A),
    .row = ROW_TABLE(harmonic_diffusion_row),
};

const Term divtau_diffusion = {
    .name = "div tau diffusion",
    .source = "P5 eq. 18, 19",
    .equation =
        "du_i/dt = (mu_0 - mu_1) <grad C/rho> . (grad u + grad u^T) + mu~_i/rho~_i 2 dim/D_i sum_j (u_j - u_i) k_ij",
    .on = ON_FLUID,
    .needed = is_divtau,
    .needs = NEED_W | NEED_V,
    .writes = FIELD(A),
    .row = ROW_TABLE(divtau_diffusion_row),
};

const Term conservative_diffusion = {
    .name = "conservative diffusion",
    .source = "schemes/differences.md",
    .equation = "harmonic, and (mu_0 - mu_1) <grad C/rho> . grad u^T",
    .on = ON_FLUID,
    .needed = is_conservative,
    .needs = NEED_W | NEED_V,
    .writes = FIELD(A),
    .row = ROW_TABLE(conservative_diffusion_row),
};

const Term sph_diffusion = {
    .name = "smoothed-particle diffusion",
    .source = "P5 eq. 13",
    .equation = "rho~_i du_i/dt = 1/V_i sum_j mu_ij (V_i^2 + V_j^2) (u_i - u_j) F",
    .on = ON_FLUID,
    .needed = is_sph,
    .needs = NEED_F | NEED_V | NEED_STATE,
    .writes = FIELD(A),
    .row = ROW_TABLE(sph_diffusion_row),
};
