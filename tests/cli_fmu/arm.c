/* An arm turned by a motor, J q'' = tau - b q' - mgl sin q, as an FMU of version VERSION (2 or 3).
   CRASH_AT: it crashes where q is beyond. LATER: it has an event at that time. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { Q, DQ, DER_Q, DER_DQ, TAU, J, B, MGL, TURN, COUNT };
typedef struct { double at[COUNT]; } Arm;

static void *made(const char *token) {
    Arm *arm;
    if (strcmp(token, "{arm}") != 0) return NULL;
    arm = calloc(1, sizeof(Arm));
    arm->at[J] = 0.05;
    arm->at[B] = 0.03;
    arm->at[MGL] = 0.4;
    puts("what is printed is no answer");
    fflush(stdout);
    return arm;
}

static void evaluate(Arm *arm) {
    double *x = arm->at;
#ifdef CRASH_AT
    if (x[Q] > CRASH_AT) abort();
#endif
    x[DER_Q] = x[DQ];
    x[DER_DQ] = (x[TAU] - x[B] * x[DQ] - x[MGL] * sin(x[Q])) / x[J];
    x[TURN] = x[Q] + 0.1 * x[DQ];
}

static int set(Arm *arm, const uint32_t *r, size_t n, const double *v) {
    for (size_t k = 0; k < n; k++) {
        if (r[k] >= COUNT) return 3;
        arm->at[r[k]] = v[k];
    }
    return 0;
}

static int get(Arm *arm, const uint32_t *r, size_t n, double *v) {
    evaluate(arm);
    for (size_t k = 0; k < n; k++) v[k] = arm->at[r[k]];
    return 0;
}

/* The derivative of one by another, for derivatives of states by states and the input. */
static double slope(const double *x, uint32_t of, uint32_t by) {
    if (of == DER_Q) return by == DQ;
    if (by == Q) return -x[MGL] * cos(x[Q]) / x[J];
    if (by == DQ) return -x[B] / x[J];
    return by == TAU ? 1 / x[J] : 0;
}

static int directional(Arm *arm, const uint32_t *of, size_t n, const uint32_t *by, size_t m, const double *seed,
                       double *to) {
    for (size_t i = 0; i < n; i++) {
        to[i] = 0;
        for (size_t j = 0; j < m; j++) to[i] += slope(arm->at, of[i], by[j]) * seed[j];
    }
    return 0;
}

#if VERSION == 2
typedef struct { int needed, terminate, nominals, values, timed; double time; } Info;
void *fmi2Instantiate(const char *name, int kind, const char *token, const char *resources, const void *calls,
                      int visible, int logging) { return kind == 0 ? made(token) : NULL; }
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetupExperiment(void *c, int a, double b, double d, int e, double f) { return 0; }
int fmi2EnterInitializationMode(void *c) { return 0; }
int fmi2ExitInitializationMode(void *c) { return 0; }
int fmi2EnterContinuousTimeMode(void *c) { return 0; }
int fmi2NewDiscreteStates(void *c, Info *info) {
    memset(info, 0, sizeof(Info));
#ifdef LATER
    info->timed = 1;
    info->time = LATER;
#endif
    return 0;
}
int fmi2SetTime(void *c, double t) { return 0; }
int fmi2SetContinuousStates(void *c, const double *x, size_t n) { memcpy(c, x, n * sizeof(double)); return 0; }
int fmi2GetDerivatives(void *c, double *d, size_t n) {
    evaluate(c);
    memcpy(d, ((Arm *)c)->at + DER_Q, n * sizeof(double));
    return 0;
}
int fmi2SetReal(void *c, const uint32_t *r, size_t n, const double *v) { return set(c, r, n, v); }
int fmi2GetReal(void *c, const uint32_t *r, size_t n, double *v) { return get(c, r, n, v); }
int fmi2GetDirectionalDerivative(void *c, const uint32_t *of, size_t n, const uint32_t *by, size_t m,
                                 const double *seed, double *to) { return directional(c, of, n, by, m, seed, to); }
#else
void *fmi3InstantiateModelExchange(const char *name, const char *token, const char *resources, bool visible,
                                   bool logging, void *environment, void *log) { return made(token); }
void fmi3FreeInstance(void *c) { free(c); }
int fmi3EnterInitializationMode(void *c, bool a, double b, double d, bool e, double f) { return 0; }
int fmi3ExitInitializationMode(void *c) { return 0; }
int fmi3EnterContinuousTimeMode(void *c) { return 0; }
int fmi3UpdateDiscreteStates(void *c, bool *needed, bool *terminate, bool *nominals, bool *values, bool *timed,
                             double *time) {
    *needed = *terminate = *nominals = *values = *timed = false;
    return 0;
}
int fmi3SetTime(void *c, double t) { return 0; }
int fmi3SetContinuousStates(void *c, const double *x, size_t n) { memcpy(c, x, n * sizeof(double)); return 0; }
int fmi3GetContinuousStateDerivatives(void *c, double *d, size_t n) {
    evaluate(c);
    memcpy(d, ((Arm *)c)->at + DER_Q, n * sizeof(double));
    return 0;
}
int fmi3SetFloat64(void *c, const uint32_t *r, size_t n, const double *v, size_t m) { return set(c, r, n, v); }
int fmi3GetFloat64(void *c, const uint32_t *r, size_t n, double *v, size_t m) { return get(c, r, n, v); }
int fmi3GetDirectionalDerivative(void *c, const uint32_t *of, size_t n, const uint32_t *by, size_t m,
                                 const double *seed, size_t s, double *to, size_t t) {
    return directional(c, of, n, by, m, seed, to);
}
#endif
