"""Write ``bibi.xsd`` again."""

from nrp_bibi.schema import SCHEMA, schema_text

SCHEMA.write_text(schema_text(), encoding="utf-8")
