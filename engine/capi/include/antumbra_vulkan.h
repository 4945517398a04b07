/* Antumbra's executor and renderer, which need Vulkan, with all that antumbra.h has: the decisions.
 * Include it in place of antumbra.h, or before it. */

#ifndef ANTUMBRA_VULKAN_H
#define ANTUMBRA_VULKAN_H

#if defined(ANTUMBRA_H) && !defined(ANTUMBRA_VULKAN)
#error "antumbra.h was included without Vulkan: include antumbra_vulkan.h first"
#endif

#ifndef ANTUMBRA_VULKAN
#define ANTUMBRA_VULKAN
#endif
#include <antumbra.h>

#endif
