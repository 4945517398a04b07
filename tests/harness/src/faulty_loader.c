/* A Vulkan loader that calls the real one. FAULT is FUNCTION CALL CODE: the function returns the code without an
   effect, from that call on, counted from 1. REAL_LOADER is the real library. The number of calls of the function is
   written to the file CALLS at the end. */
#include <dlfcn.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* On x86-64 and AArch64 up to six integers and pointers are passed in the same registers whatever their types. */
typedef int32_t (*Call)(uint64_t, uint64_t, uint64_t, uint64_t, uint64_t, uint64_t);
typedef Call (*Lookup)(void *object, const char *name);

static Lookup real_of_instance, real_of_device;
static Call real_call;
static char fault_name[128];
static int fault_call, fault_code;
static atomic_int calls;

__attribute__((destructor)) static void write_calls(void) {
    const char *path = getenv("CALLS");
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file) return;
    fprintf(file, "%d", atomic_load(&calls));
    fclose(file);
}

static int32_t faulty(uint64_t a, uint64_t b, uint64_t c, uint64_t d, uint64_t e, uint64_t f) {
    if (atomic_fetch_add(&calls, 1) + 1 >= fault_call) return fault_code;
    return real_call(a, b, c, d, e, f);
}

static Call wrapped(const char *name, Call real) {
    if (!real || strcmp(name, fault_name) != 0) return real;
    real_call = real;
    return faulty;
}

static Call of_device(void *device, const char *name) { return wrapped(name, real_of_device(device, name)); }

Call vkGetInstanceProcAddr(void *instance, const char *name) {
    if (!real_of_instance) {
        const char *path = getenv("REAL_LOADER"), *fault = getenv("FAULT");
        void *library = path ? dlopen(path, RTLD_NOW | RTLD_LOCAL) : NULL;
        if (!library || !fault || sscanf(fault, "%127s %d %d", fault_name, &fault_call, &fault_code) != 3) abort();
        *(void **)&real_of_instance = dlsym(library, "vkGetInstanceProcAddr");
    }
    Call real = real_of_instance(instance, name);
    if (strcmp(name, "vkGetInstanceProcAddr") == 0) return (Call)vkGetInstanceProcAddr;
    if (strcmp(name, "vkGetDeviceProcAddr") == 0) {
        real_of_device = (Lookup)real;
        return (Call)of_device;
    }
    return wrapped(name, real);
}
