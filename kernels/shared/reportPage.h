/* SPDX-License-Identifier: Apache-2.0
 * The residency table of the report's own design (HDS_REQUEST_FIRST): what its words carry beside
 * those of shared/residency.h. Explained in docs/streaming.md, Report mode. */
#ifndef HDS_SHARED_REPORT_PAGE_H
#define HDS_SHARED_REPORT_PAGE_H
#include "shared/residency.h"

/* Set beside an address or HDS_NOT_RESIDENT: every ray of the present batch has visited the page.
 */
#define HDS_PAGE_DONE 0x80000000u

#endif
