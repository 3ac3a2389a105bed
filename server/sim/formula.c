/* SPDX-License-Identifier: BSD-3-Clause */
/* Formulas by Lua: a state of its own for each, with a cap on memory and on instructions, so that no case can hang or
 * exhaust the program. */
#include "sim/formula.h"
#include <lauxlib.h>
#include <lua.h>
#include <lualib.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MEMORY_MAX = 1 << 20, INSTRUCTIONS_MAX = 1000000, VARIABLES_MAX = 320, FAILURE_SIZE = 200 };

struct Formula {
    lua_State *lua;
    size_t used; /* bytes of memory */
    int n_variables;
    bool condition; /* true or false, not a number */
    bool mixed;     /* may be either */
    bool constant;  /* uses no variable, so that ... */
    double value;   /* ... this is its value anywhere */
    char *failure;  /* [FAILURE_SIZE] why it failed first; empty if it never did */
};

static const char *const FUNCTIONS[] = {"abs",  "acos", "asin", "atan", "ceil", "cos", "deg",  "exp", "floor",
                                        "fmod", "log",  "max",  "min",  "rad",  "sin", "sqrt", "tan", "pi"};

static bool is_among(const char *name, const char *const *list, size_t n)
{
    for (size_t k = 0; k < n; k++)
        if (!strcmp(name, list[k])) return true;
    return false;
}

bool formula_is_word(const char *name)
{
    static const char *const words[] = {"and",      "break",  "do",   "else", "elseif", "end",  "false", "for",
                                        "function", "goto",   "if",   "in",   "local",  "nil",  "not",   "or",
                                        "repeat",   "return", "then", "true", "until",  "while"};
    return is_among(name, words, sizeof words / sizeof *words);
}

const char *formula_reserved(const char *name)
{
    static const char *const variables[] = {"x", "y", "z", "t", "dx", "step"}; /* step: of conditions of breakpoints */
    if (is_among(name, variables, sizeof variables / sizeof *variables)) return "a variable of formulas";
    if (is_among(name, FUNCTIONS, sizeof FUNCTIONS / sizeof *FUNCTIONS)) return "a function of formulas, or pi";
    const bool is_inner = name[0] == '_' && name[1] >= 'A' && name[1] <= 'Z'; /* _ENV is where Lua finds all others */
    return formula_is_word(name) || is_inner ? "a word of Lua" : NULL;
}

static void *allocate(void *arg, void *old, size_t old_size, size_t size)
{
    Formula *f = arg;
    if (!old) old_size = 0;
    if (f->used - old_size + size > MEMORY_MAX) return NULL;
    if (!size) {
        free(old);
        f->used -= old_size;
        return NULL;
    }
    void *p = realloc(old, size);
    if (p) f->used += size - old_size;
    return p;
}

static void too_long(lua_State *lua, lua_Debug *debug)
{
    (void)debug;
    luaL_error(lua, "it runs too long");
}

static int unknown_name(lua_State *lua)
{
    return luaL_error(lua, "unknown name '%s'", lua_tostring(lua, 2));
}

/* Globals: the mathematics by short names; anything else is an error when it is used. Runs protected. */
static int open_names(lua_State *lua)
{
    luaL_requiref(lua, "math", luaopen_math, 0);
    for (size_t k = 0; k < sizeof FUNCTIONS / sizeof *FUNCTIONS; k++) {
        lua_getfield(lua, -1, FUNCTIONS[k]);
        lua_setglobal(lua, FUNCTIONS[k]);
    }
    lua_pushglobaltable(lua);
    lua_createtable(lua, 0, 1);
    lua_pushcfunction(lua, unknown_name);
    lua_setfield(lua, -2, "__index");
    lua_setmetatable(lua, -2);
    lua_settop(lua, 0);
    return 0;
}

/* "local x,y = ... return (TEXT\n)", as a function of the variables. Runs protected, as memory may not suffice. */
static int load_text(lua_State *lua)
{
    const char *text = lua_touserdata(lua, 1), *const *variables = lua_touserdata(lua, 2);
    luaL_Buffer source;
    luaL_buffinit(lua, &source);
    for (size_t k = 0; variables[k]; k++) {
        luaL_addstring(&source, k ? "," : "local ");
        luaL_addstring(&source, variables[k]);
    }
    if (variables[0]) luaL_addstring(&source, " = ... ");
    luaL_addstring(&source, "return (");
    luaL_addstring(&source, text);
    luaL_addstring(&source, "\n)");
    luaL_pushresult(&source);
    if (luaL_loadbufferx(lua, lua_tostring(lua, -1), lua_rawlen(lua, -1), "=formula", "t") != LUA_OK)
        return lua_error(lua);
    return 1;
}

/* The function on the stack; or what is wrong with the text. */
static int compile(lua_State *lua, const char *text, const char *const *variables)
{
    lua_pushcfunction(lua, load_text);
    lua_pushlightuserdata(lua, (void *)text);
    lua_pushlightuserdata(lua, (void *)variables);
    return lua_pcall(lua, 2, 1, 0);
}

/* A global of that name and value. Runs protected. */
static int set_constant(lua_State *lua)
{
    lua_setglobal(lua, lua_touserdata(lua, 1));
    return 0;
}

/* Call the function on top of the stack, leaving it there; NAN and false if it fails, with the message on the stack. */
static bool call(lua_State *lua, const double *values, int n, double *ret, bool *ret_condition)
{
    lua_sethook(lua, too_long, LUA_MASKCOUNT, INSTRUCTIONS_MAX);
    lua_pushvalue(lua, -1);
    for (int k = 0; k < n; k++) lua_pushnumber(lua, values[k]);
    if (lua_pcall(lua, n, 1, 0) != LUA_OK) return false;
    if (ret_condition) *ret_condition = lua_isboolean(lua, -1);
    if (lua_isboolean(lua, -1)) *ret = lua_toboolean(lua, -1);
    else if (lua_type(lua, -1) == LUA_TNUMBER) *ret = lua_tonumber(lua, -1);
    else {
        lua_pop(lua, 1);
        lua_pushnil(lua); /* as a text would ask for memory, where nobody catches its refusal */
        return false;
    }
    lua_pop(lua, 1);
    return true;
}

/* The message on top of the stack without the place Lua puts before it, which the user never sees. */
static const char *message(lua_State *lua)
{
    if (lua_isnil(lua, -1)) return "it is neither a number nor true or false";
    if (lua_type(lua, -1) != LUA_TSTRING) return "it fails";
    const char *text = lua_tostring(lua, -1);
    int length = 0; /* of the place: the name given to the chunk, a line, a colon */
    sscanf(text, "formula:%*d: %n", &length);
    return text + length;
}

static MnsStatus complain(lua_State *lua, const char *text, MnsError *error)
{
    return mns_fail(error, MNS_E_INVALID, "\"%.120s\" is not a formula: %.200s", text, message(lua));
}

static MnsStatus define(lua_State *lua, const MnsConstant *constant, MnsError *error)
{
    static const char *const none[] = {NULL};
    double value = NAN;
    if (compile(lua, constant->value, none) != LUA_OK || !call(lua, NULL, 0, &value, NULL))
        return complain(lua, constant->value, error);
    lua_pushcfunction(lua, set_constant);
    lua_pushlightuserdata(lua, constant->name);
    lua_pushnumber(lua, value);
    if (lua_pcall(lua, 2, 0, 0) != LUA_OK) return complain(lua, constant->value, error);
    lua_settop(lua, 0);
    return MNS_OK;
}

/* Does a name stand in a text? In a string it does too, which costs nothing but time. */
static bool is_mentioned(const char *name, const char *text)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
    while (*(text += strcspn(text, letters))) {
        const size_t n = strspn(text, letters);
        if (strlen(name) == n && !memcmp(name, text, n)) return true;
        text += n;
    }
    return false;
}

static bool is_constant(const char *text, const char *const *variables)
{
    for (size_t k = 0; variables[k]; k++)
        if (is_mentioned(variables[k], text)) return false;
    return true;
}

static MnsStatus prepare(Formula *f, const char *text, const char *const *variables, const MnsConstant *constants,
                         size_t n, MnsError *error)
{
    lua_State *lua = f->lua;
    lua_pushcfunction(lua, open_names);
    if (!lua_checkstack(lua, VARIABLES_MAX + LUA_MINSTACK) || lua_pcall(lua, 0, 0, 0) != LUA_OK)
        return mns_fail(error, MNS_E_MEMORY, "no memory for a formula");
    for (size_t k = 0; k < n; k++) {
        const MnsStatus status = define(lua, &constants[k], error);
        if (status) return status;
    }
    if (compile(lua, text, variables) != LUA_OK) return complain(lua, text, error);
    /* A first call finds unknown names; 0.5 is as good a place as any and in the domain of log and sqrt. */
    double values[VARIABLES_MAX], value = NAN;
    for (int k = 0; k < f->n_variables; k++) values[k] = 0.5;
    if (!call(lua, values, f->n_variables, &value, &f->condition)) return complain(lua, text, error);
    f->constant = is_constant(text, variables);
    f->value = value;
    return MNS_OK;
}

MnsStatus formula_new(const char *text, const char *const *variables, const MnsConstant *constants, size_t n,
                      Formula **ret, MnsError *error)
{
    Formula *f = calloc(1, sizeof *f);
    if (f) f->failure = calloc(1, FAILURE_SIZE);
    if (f && f->failure) f->lua = lua_newstate(allocate, f);
    if (!f || !f->lua) {
        if (f) free(f->failure);
        free(f);
        return mns_fail(error, MNS_E_MEMORY, "no memory for a formula");
    }
    while (variables[f->n_variables]) f->n_variables++;
    MnsStatus status = f->n_variables > VARIABLES_MAX
                           ? mns_fail(error, MNS_E_LIMIT, "a formula may have %d variables at most", VARIABLES_MAX)
                           : prepare(f, text, variables, constants, n, error);
    if (status) {
        formula_free(f);
        return status;
    }
    *ret = f;
    return MNS_OK;
}

static double failed(const Formula *f, const char *why)
{
    if (!*f->failure) snprintf(f->failure, FAILURE_SIZE, "%s", why);
    return NAN;
}

double formula_eval(const Formula *formula, const double *values)
{
    double value = NAN;
    bool condition = false;
    if (formula->constant) return formula->value;
    if (!call(formula->lua, values, formula->n_variables, &value, &condition)) {
        failed(formula, message(formula->lua));
        lua_pop(formula->lua, 1);
        return NAN;
    }
    if (condition == formula->condition || formula->mixed) return value;
    return failed(formula, condition ? "it is true or false there, and a number elsewhere"
                                     : "it is a number there, and true or false elsewhere");
}

const char *formula_failure(const Formula *formula)
{
    return *formula->failure ? formula->failure : NULL;
}

bool formula_is_constant(const Formula *formula)
{
    return formula->constant;
}

void formula_mix(Formula *formula)
{
    formula->mixed = true;
}

bool formula_is_condition(const Formula *formula)
{
    return formula->condition;
}

void formula_free(Formula *formula)
{
    if (!formula) return;
    lua_close(formula->lua);
    free(formula->failure);
    free(formula);
}

MnsStatus formula_team_init(FormulaTeam *team, int threads, const char *text, const char *const *variables,
                            const MnsConstant *constants, size_t n, MnsError *error)
{
    *team = (FormulaTeam){.n = 0, .member = calloc((size_t)threads, sizeof *team->member)};
    if (!team->member) return mns_fail(error, MNS_E_MEMORY, "no memory for a formula");
    while (team->n < threads && !team->shared) {
        const MnsStatus status = formula_new(text, variables, constants, n, &team->member[team->n], error);
        if (status) {
            formula_team_done(team);
            return status;
        }
        team->shared = team->member[team->n++]->constant;
    }
    return MNS_OK;
}

void formula_team_done(FormulaTeam *team)
{
    for (int k = 0; k < team->n; k++) formula_free(team->member[k]);
    free(team->member);
    *team = (FormulaTeam){0};
}

void formula_team_forget(FormulaTeam *team)
{
    for (int k = 0; k < team->n; k++) *team->member[k]->failure = 0;
}

const char *formula_team_failure(const FormulaTeam *team)
{
    for (int k = 0; k < team->n; k++)
        if (formula_failure(team->member[k])) return formula_failure(team->member[k]);
    return NULL;
}
